#include "scene/medium_schema.h"

#include "scene/medium.h"
#include "scene/schema_builder.h"

namespace dapple::scene {
namespace {

using namespace build;

constexpr double kMostStep = 1000;

const Structure& phase_sample_schema() {
    static const Structure table{
        "sample of a phase function",
        {
            number<&PhaseSample::angle>("angle", Dimension::angle,
                                        "between the ways before and after: 0 is straight on")
                .within(0, radians_from_degrees(180))
                .constant()
                .required(),
            number<&PhaseSample::value>("value", Dimension::number, "relative; the whole is normalised")
                .at_least(0)
                .constant()
                .required(),
        },
        "",
        {},
        nullptr};
    return table;
}

}  // namespace

const Structure& phase_schema() {
    constexpr std::string_view kTwoLobe = "two_lobe";
    constexpr std::string_view kOcean = "fournier_forand";
    static const Structure table{
        "phase function",
        {
            choice<&PhaseFunction::type>(
                "type", {"isotropic", "henyey_greenstein", "two_lobe", "fournier_forand", "table"},
                "how scattered light is shared among directions")
                .required(),
            number<&PhaseFunction::anisotropy>("anisotropy", Dimension::number,
                                               "mean cosine of the scattering angle; of the first lobe")
                .within(-0.75, 0.99)
                .only_for({"henyey_greenstein", kTwoLobe}),
            number<&PhaseFunction::back_anisotropy>("back_anisotropy", Dimension::number,
                                                    "mean cosine of the second lobe")
                .within(-0.75, 0.99)
                .only_for({kTwoLobe}),
            number<&PhaseFunction::forward_share>("forward_share", Dimension::number,
                                                  "of the light, that the first lobe takes")
                .within(0, 1)
                .only_for({kTwoLobe}),
            number<&PhaseFunction::particle_index>("particle_index", Dimension::number,
                                                   "refractive index of the particles against the water")
                .range({1, 2, true, false})
                .only_for({kOcean}),
            number<&PhaseFunction::size_slope>("size_slope", Dimension::number,
                                               "exponent of the hyperbolic distribution of particle sizes")
                .range({3, 5, true, true})
                .only_for({kOcean}),
            list<&PhaseFunction::samples>("table", phase_sample_schema(),
                                          "from small angles to large; linear between, constant beyond")
                .required()
                .only_for({"table"}),
        },
        "type",
        {},
        nullptr};
    return table;
}

const Structure& medium_schema() {
    constexpr std::string_view kGrid = "grid";
    static const Structure table{
        "medium",
        {
            member<&Medium::name>("name", FieldKind::text, "for --set and messages"),
            choice<&Medium::type>("type", {"box", "grid"}, "homogeneous inside a box, or OpenVDB files")
                .required(),
            choice<&Medium::side>("side", {"everywhere", "air", "water"},
                                  "of the water's surface where it is; what reaches across is cut off"),
            number<&Medium::density>("density", Dimension::number, "factor of all densities").at_least(0),
            number<&Medium::extinction>("extinction", Dimension::per_length,
                                        "red, green, blue, where density is 1: absorbed and scattered")
                .at_least(0)
                .one_for_all(),
            number<&Medium::albedo>("albedo", Dimension::number,
                                    "share of the extinction that is scattered, red, green, blue")
                .within(0, 1)
                .one_for_all(),
            structure<&Medium::phase>("phase", phase_schema(), "of the scattering; not given: isotropic"),
            number<&Medium::transform, &Transform::position>("position", Dimension::length,
                                                             "of the box's centre, or of the files' origin"),
            number<&Medium::transform, &Transform::rotation>(
                "rotation", Dimension::angle, "about x, y, z; turned about z first, then x, then y"),
            number<&Medium::transform, &Transform::scale>("scale", Dimension::number, "along x, y, z")
                .above(0)
                .one_for_all(),
            number<&Medium::size>("size", Dimension::length, "along x, y, z").above(0).only_for({"box"}),
            member<&Medium::file>("file", FieldKind::path,
                                  "OpenVDB; for a sequence with a place for the number: smoke.%04d.vdb")
                .required()
                .only_for({kGrid}),
            member<&Medium::grid>("grid", FieldKind::text, "of the file, the one that holds the density")
                .only_for({kGrid}),
            integral<&Medium::first_file>("first_file", FieldKind::integer,
                                          "number of the file shown at the clip's first frame")
                .within(0, kMost)
                .only_for({kGrid}),
            integral<&Medium::last_file>("last_file", FieldKind::integer,
                                         "after it the sequence holds or begins again")
                .within(0, kMost)
                .only_for({kGrid}),
            number<&Medium::step>("step", Dimension::number, "files a frame; the last that began is shown")
                .within(0, kMostStep)
                .constant()
                .only_for({kGrid}),
            integral<&Medium::loop>("loop", FieldKind::boolean, "whether it begins again after last_file")
                .only_for({kGrid}),
            choice<&Medium::missing>("missing", {"error", "hold", "empty"},
                                     "a file that is not there: an error, the one before holds, or nothing")
                .only_for({kGrid}),
            integral<&Medium::z_up>("z_up", FieldKind::boolean,
                                    "whether the files' z axis points up (turned so that it becomes y)")
                .only_for({kGrid}),
        },
        "type",
        {},
        nullptr};
    return table;
}

}  // namespace dapple::scene
