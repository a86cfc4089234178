#include "scene/schema.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/denoise_schema.h"
#include "scene/light_schema.h"
#include "scene/medium_schema.h"
#include "scene/schema_builder.h"
#include "scene/water_schema.h"

namespace dapple::scene {
namespace {

using namespace build;

constexpr double kMostPixels = 16384;  // along a side: what Vulkan devices and picture readers take
constexpr std::array<std::string_view, 5> kCausticMethods{"sliced_beams", "photon_splatting", "reference",
                                                          "adaptive_beams", "caustic_mesh"};

const std::initializer_list<std::string_view> kAllButReference{
    "sliced_beams", "photon_splatting", "adaptive_beams", "caustic_mesh"};  // it is the truth as it is
const std::initializer_list<std::string_view> kMapMethods{
    "photon_splatting", "caustic_mesh"};  // those that start from a caustic map

const Structure& clip_schema() {
    static const Structure table{
        "clip",
        {
            member<&Clip::name>("name", FieldKind::file_name, "stem of the names of all files written"),
            member<&Clip::fps>("fps", FieldKind::frame_rate,
                               "frames a second, whole or a fraction (24000/1001)"),
            whole("frames", FieldKind::frame_range,
                  "first and last frame, both included: 1-48; or one frame"),
            whole("resolution", FieldKind::resolution, "width and height in pixels").within(1, kMostPixels),
            integral<&Clip::samples>("samples", FieldKind::integer, "camera paths a pixel").within(1, 1024),
            integral<&Clip::seed>("seed", FieldKind::integer, "of all random numbers").within(0, kMostSeed),
        },
        "",
        {},
        nullptr};
    return table;
}

const Structure& camera_schema() {
    static const Structure table{
        "camera",
        {
            choice<&Camera::projection>("projection", {"perspective", "orthographic"}, "how the camera sees"),
            number<&Camera::position>("position", Dimension::length, "where the camera stands"),
            number<&Camera::target>("target", Dimension::length, "the point at the middle of the picture"),
            number<&Camera::up>("up", Dimension::number,
                                "what is up in the picture; not along the line of sight"),
            number<&Camera::field_of_view>("field_of_view", Dimension::angle,
                                           "from the lower edge to the upper")
                .range({0, radians_from_degrees(180), true, true})
                .only_for({"perspective"}),
            number<&Camera::view_height>("view_height", Dimension::length,
                                         "height of the picture, at any depth")
                .above(0)
                .only_for({"orthographic"}),
        },
        "projection",
        {},
        nullptr};
    return table;
}

const Structure& material_schema() {
    static const Structure table{
        "material",
        {
            number<&Material::color>("color", Dimension::number,
                                     "share of light that is reflected, red, green, blue")
                .within(0, 1)
                .one_for_all(),
            member<&Material::texture>("texture", FieldKind::path, "EXR or PNG; multiplies the colour"),
            number<&Material::texture_size>("texture_size", Dimension::length,
                                            "covered by one repeat of the texture")
                .above(0),
            integral<&Material::mirror>("mirror", FieldKind::boolean,
                                        "reflects like a mirror, tinted by the colour"),
            integral<&Material::glass>("glass", FieldKind::boolean,
                                       "a body of clear glass, or what refracts like it: box, sphere or "
                                       "closed mesh, without colour"),
            number<&Material::refractive_index>("refractive_index", Dimension::number,
                                                "of glass, against air")
                .within(1, 4),
            number<&Material::absorption>("absorption", Dimension::per_length,
                                          "inside glass, red, green, blue")
                .at_least(0)
                .one_for_all(),
        },
        "",
        {},
        nullptr};
    return table;
}

const Structure& object_schema() {
    static const Structure table{
        "object",
        {
            member<&Object::name>("name", FieldKind::text, "for --set and messages"),
            choice<&Object::shape>("shape", {"plane", "box", "sphere", "mesh"},
                                   "a plane lies flat and faces up")
                .required(),
            number<&Object::size>("size", Dimension::length,
                                  "along x, y, z; a plane has no thickness, so y is unused")
                .above(0)
                .only_for({"plane", "box"}),
            number<&Object::radius>("radius", Dimension::length, "").above(0).only_for({"sphere"}),
            member<&Object::file>("file", FieldKind::path, "PLY or OBJ").required().only_for({"mesh"}),
            number<&Object::transform, &Transform::position>("position", Dimension::length,
                                                             "of the shape's centre"),
            number<&Object::transform, &Transform::rotation>(
                "rotation", Dimension::angle, "about x, y, z; turned about z first, then x, then y"),
            number<&Object::transform, &Transform::scale>("scale", Dimension::number,
                                                          "along x, y, z; one for a sphere")
                .above(0)
                .one_for_all(),
            structure<&Object::material>("material", material_schema(), "diffuse, a mirror, or glass"),
        },
        "shape",
        {},
        nullptr};
    return table;
}

const Structure& sky_schema() {
    static const Structure table{
        "sky",
        {
            number<&Sky::radiance>("radiance", Dimension::radiance, "the same from all directions of the air")
                .at_least(0)
                .one_for_all(),
        },
        "",
        {},
        nullptr};
    return table;
}

/// The method is kept by its name, which names the folder of its code.
Row caustic_method() {
    Field field;
    field.key = "method";
    field.kind = FieldKind::choice;
    field.doc = "how caustics are computed; its parameters stand beside it";
    field.choices.assign(kCausticMethods.begin(), kCausticMethods.end());
    field.get = [](const void* object) {
        const std::string& name = static_cast<const Caustics*>(object)->method;
        return static_cast<std::int64_t>(std::find(kCausticMethods.begin(), kCausticMethods.end(), name) -
                                         kCausticMethods.begin());
    };
    field.set = [](void* object, std::int64_t index) {
        static_cast<Caustics*>(object)->method = kCausticMethods[static_cast<std::size_t>(index)];
    };
    return {field};
}

const Structure& cascade_map_schema() {
    static const Structure table{
        "cascade map",
        {
            integral<&CascadeMap::resolution>("resolution", FieldKind::integer,
                                              "photons along each side of the cascade's box")
                .within(1, kMost)
                .required(),
        },
        "",
        {},
        nullptr};
    return table;
}

const Structure& caustics_schema() {
    constexpr auto map = &Caustics::map;
    static const Structure table{
        "caustics",
        {
            caustic_method(),
            choice<&Caustics::volume_resolution>(
                "volume_resolution", {"full", "half"},
                "pixels for which light scattered by media is computed; half: every second, each way"),
            choice<&Caustics::buffer_scale>(
                "buffer_scale", {"full", "half", "quarter"},
                "pixels for which caustics on surfaces are computed; half: every second, each way; "
                "interpolated between, not over edges")
                .only_for(kAllButReference),
            structure<&Caustics::denoise>("denoise", denoise_schema(),
                                          "a filter over caustics on surfaces, not over their textures")
                .only_for(kAllButReference),
            number<&Caustics::target_error>(
                "target_error", Dimension::number,
                "relative L1 of E over the picture that map_resolution is chosen for, and what of footprint "
                "and "
                "denoise.passes is not given; estimated in the clip's first, middle and last frame")
                .within(1e-3, 0.5)
                .no_default()
                .constant()
                .only_for(kMapMethods),
            integral<map, &CausticMapParameters::map_resolution>(
                "map_resolution", FieldKind::integer,
                "photons along each side of a cascade's box; of one map over all the water: along its longer "
                "side")
                .within(1, kMost)
                .only_for(kMapMethods),
            number<map, &CausticMapParameters::map_precision>(
                "map_precision", Dimension::length,
                "that photons of the innermost map lie apart, instead of map_resolution; 0: not given")
                .at_least(0)
                .constant()
                .only_for(kMapMethods),
            integral<map, &CausticMapParameters::cascades>("cascades", FieldKind::integer,
                                                           "maps inside each other, coarser outwards")
                .within(1, 8)
                .only_for(kMapMethods),
            number<map, &CausticMapParameters::cascade_scale>(
                "cascade_scale", Dimension::number,
                "by which each box is wider, and its photons lie wider, than those inside it")
                .within(1.1, 16)
                .constant()
                .only_for(kMapMethods),
            number<map, &CausticMapParameters::inner_size>(
                "inner_size", Dimension::length,
                "side of the innermost box; 0: the outermost box is as wide as the water")
                .at_least(0)
                .constant()
                .only_for(kMapMethods),
            choice<map, &CausticMapParameters::cascade_center>("cascade_center",
                                                               {"camera", "target", "extent"},
                                                               "what the boxes lie about: where the camera "
                                                               "stands, what it looks at, or the water's "
                                                               "middle")
                .only_for(kMapMethods),
            list<map, &CausticMapParameters::cascade_maps>("cascade_maps", cascade_map_schema(),
                                                           "a map for each cascade, the innermost first, "
                                                           "instead of map_resolution")
                .only_for(kMapMethods),
            integral<map, &CausticMapParameters::paper_faithful>(
                "paper_faithful", FieldKind::boolean,
                "as Kougianos and Moustakas 2021: hard borders, boxes in the light's frame that follow the "
                "camera; of caustic_mesh as Ouyang and Yang 2020 too: triangles of one brightness, none at "
                "edges of objects; of photon_splatting as the footprints' papers: drawn as a raster does, "
                "held to receivers by depth")
                .only_for(kMapMethods),
            integral<map, &CausticMapParameters::second_bounce>(
                "second_bounce", FieldKind::boolean,
                "whether light of the water that lands on mirrors is sent on, to where it lands next")
                .only_for(kMapMethods),
            choice<&Caustics::photon_splatting, &PhotonSplattingParameters::footprint>(
                "footprint", {"tent", "fixed", "photon_differential", "photon_difference", "point"},
                "what a photon lights where it lands: tent, what reproduces linear light between its "
                "neighbours' landing points; fixed, its cell of the map, whatever the water does to it; "
                "photon_differential, its cell as the derivatives of its ray carry it; photon_difference, "
                "its cell between its neighbours' rays; point, the sample's own part of a pixel, and with "
                "paper_faithful Gruen's baseline: pixels, brightened by the cell's area on the water over "
                "that "
                "where it lands, 100 times at most")
                .only_for({"photon_splatting"}),
            number<&Caustics::photon_splatting, &PhotonSplattingParameters::footprint_scale>(
                "footprint_scale", Dimension::number,
                "of the footprint's sides, the q_0 of Kougianos and Moustakas 2021, equation 16: larger ones "
                "blur, smaller ones leave gaps; flux stays; not for point")
                .within(0.01, 100)
                .constant()
                .only_for({"photon_splatting"}),
            integral<&Caustics::sliced_beams, &SlicedBeamsParameters::sun_samples>(
                "sun_samples", FieldKind::integer,
                "equal parts of a sun's disc, each traced by its middle and widened by its size")
                .within(1, 1024)
                .only_for({"sliced_beams"}),
            integral<&Caustics::sliced_beams, &SlicedBeamsParameters::volume_sun_samples>(
                "volume_sun_samples", FieldKind::integer,
                "directions of a sun's disc that a camera path's way in media is lit from; a pixel's paths "
                "have different ones")
                .within(1, 1024)
                .only_for({"sliced_beams"}),
            integral<&Caustics::sliced_beams, &SlicedBeamsParameters::path_counts>(
                "path_counts", FieldKind::boolean,
                "whether light paths are counted: the layers paths.count, paths.sign and fold")
                .only_for({"sliced_beams"}),
            integral<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::grid>(
                "grid", FieldKind::integer, "cells along each side of a light's view before any is split")
                .within(1, 1024)
                .only_for({"adaptive_beams"}),
            integral<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::levels>(
                "levels", FieldKind::integer, "times that a cell may be split")
                .within(0, 12)
                .only_for({"adaptive_beams"}),
            number<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::tolerance>(
                "tolerance", Dimension::number,
                "pixels (of beams wider than two: half their widths) that light may land off its place; "
                "cells are "
                "split until then")
                .within(0.001, 100)
                .constant()
                .only_for({"adaptive_beams"}),
            integral<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::sun_samples>(
                "sun_samples", FieldKind::integer, "equal parts of a sun's disc, each traced by its middle")
                .within(1, 1024)
                .only_for({"adaptive_beams"}),
            integral<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::paper_faithful>(
                "paper_faithful", FieldKind::boolean,
                "as Liktor and Dachsbacher 2011: one area function a beam, scan plane, mid-point")
                .only_for({"adaptive_beams"}),
            number<&Caustics::adaptive_beams, &AdaptiveBeamsParameters::paper_low_pass>(
                "paper_low_pass", Dimension::number,
                "with paper_faithful: pixels that light on surfaces is blurred by, a standard deviation")
                .within(0, 100)
                .constant()
                .only_for({"adaptive_beams"}),
            number<&Caustics::reference, &ReferenceParameters::standard_error>(
                "standard_error", Dimension::number,
                "of E, mean over pixels over the mean of E, at which it ends")
                .above(0)
                .constant()
                .only_for({"reference"}),
            integral<&Caustics::reference, &ReferenceParameters::most_rays>(
                "most_rays", FieldKind::integer, "million a light, at which it ends in any case")
                .within(1, 1000000)
                .only_for({"reference"}),
        },
        "method",
        {},
        nullptr};
    return table;
}

const Structure& cdl_schema() {
    static const Structure table{
        "cdl",
        {
            number<&ColorDecisionList::slope>("slope", Dimension::number, "").at_least(0).one_for_all(),
            number<&ColorDecisionList::offset>("offset", Dimension::number, "").one_for_all(),
            number<&ColorDecisionList::power>("power", Dimension::number, "").above(0).one_for_all(),
            number<&ColorDecisionList::saturation>("saturation", Dimension::number, "").at_least(0),
        },
        "",
        {},
        nullptr};
    return table;
}

const Structure& output_schema() {
    static const Structure table{
        "output",
        {
            member<&Output::ocio_config>("ocio_config", FieldKind::path,
                                         "OCIO config; not given: $OCIO, else the one shipped"),
            member<&Output::display>("display", FieldKind::text, "not given: the config's default"),
            member<&Output::view>("view", FieldKind::text, "not given: the display's default"),
            member<&Output::look>("look", FieldKind::text, "not given: none"),
            number<&Output::exposure>("exposure", Dimension::exposure, "brightens by powers of two"),
            structure<&Output::cdl>("cdl", cdl_schema(), "ASC CDL, applied in the role color_timing"),
        },
        "",
        {},
        nullptr};
    return table;
}

/// Water is there only where the timeline holds its key.
Row water_row() {
    Row row = structure<&FrameState::water>("water", water_schema(), "not given: there is none");
    row.field.member = [](void* object) -> void* {
        auto& water = static_cast<FrameState*>(object)->water;
        return water ? &*water : &water.emplace();
    };
    row.field.present = [](const void* object) {
        return static_cast<const FrameState*>(object)->water.has_value();
    };
    return row;
}

}  // namespace

const Field* Structure::find(std::string_view key, std::string_view type) const {
    for (const Field& field : fields)
        if (field.key == key && (field.only_for.empty() || has(field.only_for, type))) return &field;
    return nullptr;
}

const Structure& frame_schema() {
    static const Structure table{
        "timeline",
        {
            whole("dapple", FieldKind::version, "version of the grammar of timelines, 1").required(),
            structure<&FrameState::clip>("clip", clip_schema(), "what is rendered"),
            structure<&FrameState::camera>("camera", camera_schema(), "who looks; under water, above it"),
            water_row(),
            list<&FrameState::lights>("lights", light_schema(), "suns, points, spots and area lights"),
            list<&FrameState::objects>("objects", object_schema(), "what catches the light"),
            list<&FrameState::media>("media", medium_schema(), "smoke, fog: what dims and scatters light"),
            structure<&FrameState::sky>("sky", sky_schema(), "light from where nothing is"),
            structure<&FrameState::caustics>("caustics", caustics_schema(), "the method and its parameters"),
            structure<&FrameState::output>("output", output_schema(), "how the picture is graded"),
        },
        "",
        {},
        nullptr};
    return table;
}

glm::dvec3 sun_direction(double elevation, double azimuth) {
    const double horizontal = std::cos(elevation);
    return {-horizontal * std::cos(azimuth), -std::sin(elevation), -horizontal * std::sin(azimuth)};
}

}  // namespace dapple::scene
