#include "scene/water_schema.h"

#include <cmath>
#include <numbers>

#include "scene/medium_schema.h"
#include "scene/schema_builder.h"

namespace dapple::scene {
namespace {

using namespace build;

void derive_wave(void* object, const std::vector<std::string_view>& given) {
    auto& wave = *static_cast<Wave*>(object);
    if (!has(given, "wave_vector")) return;
    const double wave_number = glm::length(wave.wave_vector);
    if (wave_number == 0) return;
    wave.length = 2 * std::numbers::pi / wave_number;
    wave.heading = std::atan2(wave.wave_vector.y, wave.wave_vector.x);
}

void derive_water(void* object, const std::vector<std::string_view>& given) {
    auto& water = *static_cast<Water*>(object);
    if (water.jerlov == JerlovType::none) return;
    const WaterCoefficients preset = jerlov_coefficients(water.jerlov);
    if (!has(given, "absorption")) water.absorption = preset.absorption;
    if (!has(given, "scattering")) water.scattering = preset.scattering;
}

const Structure& wave_schema() {
    static const Structure table{
        "wave",
        {
            number<&Wave::length>("length", Dimension::length, "from crest to crest").above(0).no_default(),
            number<&Wave::heading>("heading", Dimension::angle, "of travel: 0 is +x, 90 deg is +z"),
            number<&Wave::wave_vector>("wave_vector", Dimension::wave_number,
                                       "along x and z, in place of length and heading")
                .no_default(),
            number<&Wave::amplitude>("amplitude", Dimension::length,
                                     "half of the height from trough to crest")
                .required(),
            number<&Wave::phase>("phase", Dimension::angle, "at the origin and time 0; 0 is a crest"),
        },
        "",
        {{"", {{"length", "heading"}, {"wave_vector"}}}},
        &derive_wave};
    return table;
}

const Structure& surface_schema() {
    using Surface = WaterSurface;
    constexpr std::string_view kWaves = "waves";
    constexpr std::string_view kSpectrum = "spectrum";
    constexpr std::string_view kMeshes = "mesh_sequence";
    constexpr auto waves = &Surface::waves;
    constexpr auto sea = &Surface::spectrum;
    constexpr auto meshes = &Surface::mesh_sequence;
    static const Structure table{
        "surface",
        {
            choice<&Surface::type>("type", {"waves", "spectrum", "mesh_sequence"},
                                   "where the surface comes from")
                .required(),

            list<waves, &Waves::waves>("waves", wave_schema(), "sinusoids that add up; none is flat water")
                .only_for({kWaves}),
            number<waves, &Waves::depth>("depth", Dimension::length,
                                         "of the water, for the speed of the waves")
                .above(0)
                .only_for({kWaves}),

            number<sea, &Spectrum::wind_speed>("wind_speed", Dimension::speed, "10 m above the water")
                .range({0, 100, true, false})
                .only_for({kSpectrum}),
            number<sea, &Spectrum::wind_heading>("wind_heading", Dimension::angle,
                                                 "where it blows to: 0 is +x")
                .only_for({kSpectrum}),
            number<sea, &Spectrum::fetch>("fetch", Dimension::length, "way of the wind over the water")
                .above(0)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::depth>("depth", Dimension::length, "of the water")
                .above(0)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::peak_enhancement>("peak_enhancement", Dimension::number,
                                                     "gamma of JONSWAP")
                .within(1, 20)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::spreading>("spreading", Dimension::number, "s of cos^2s(theta / 2)")
                .within(0, 1000)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::choppiness>("choppiness", Dimension::number,
                                               "factor of horizontal displacement")
                .within(0, 10)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::cutoff_length>("cutoff_length", Dimension::length, "shortest wave")
                .above(0)
                .constant()
                .only_for({kSpectrum}),
            number<sea, &Spectrum::period>(
                "period", Dimension::length,
                "the sea repeats after it, rounded so that the extent is a whole number of periods; 0: "
                "with the extent")
                .at_least(0)
                .constant()
                .only_for({kSpectrum}),
            number<sea, &Spectrum::amplitude_scale>("amplitude_scale", Dimension::number,
                                                    "factor of all heights")
                .within(0, 1000)
                .only_for({kSpectrum}),
            number<sea, &Spectrum::loop>("loop", Dimension::time, "after which the sea repeats; 0: never")
                .at_least(0)
                .constant()
                .only_for({kSpectrum}),
            integral<sea, &Spectrum::seed>("seed", FieldKind::integer, "of the sea's random phases")
                .within(0, kMostSeed)
                .only_for({kSpectrum}),

            member<meshes, &MeshSequence::pattern>(
                "pattern", FieldKind::path_pattern,
                "PLY or OBJ files, one an instant: sea.%04d.ply or sea.####.ply")
                .required()
                .only_for({kMeshes}),
            integral<meshes, &MeshSequence::first_file>("first_file", FieldKind::integer,
                                                        "number of the file shown at the clip's first frame")
                .within(0, kMost)
                .only_for({kMeshes}),
            integral<meshes, &MeshSequence::last_file>("last_file", FieldKind::integer, "it holds to the end")
                .within(0, kMost)
                .only_for({kMeshes}),
            number<meshes, &MeshSequence::fps>("fps", Dimension::frame_rate,
                                               "files a second, also a fraction")
                .range({0, 1000, true, false})
                .constant()
                .only_for({kMeshes}),
            choice<meshes, &MeshSequence::up>("up", {"y", "z"}, "axis of the files that points up")
                .only_for({kMeshes}),
            number<meshes, &MeshSequence::scale>("scale", Dimension::number, "metres in a unit of the files")
                .above(0)
                .only_for({kMeshes}),
            number<meshes, &MeshSequence::offset>("offset", Dimension::length,
                                                  "added after scaling and turning")
                .only_for({kMeshes}),
            choice<meshes, &MeshSequence::missing>(
                "missing", {"error", "hold"}, "a file that is not there: an error, or the one before holds")
                .only_for({kMeshes}),
        },
        "type",
        {},
        nullptr};
    return table;
}

const Structure& extent_schema() {
    static const Structure table{
        "extent",
        {
            choice<&Extent::kind>("type", {"pool", "open"},
                                  "pool: water ends at the rectangle; open: the camera sees it go on, flat"),
            number<&Extent::center>("center", Dimension::length, "x and z"),
            number<&Extent::size>("size", Dimension::length, "along x and z").above(0),
        },
        "",
        {},
        nullptr};
    return table;
}

const Structure& rings_schema() {
    static const Structure table{
        "rings",
        {
            number<&WaterRings::inner_size>("inner_size", Dimension::length, "side of the innermost square")
                .above(0)
                .constant()
                .required(),
            integral<&WaterRings::cells>("cells", FieldKind::integer,
                                         "across each ring; in the next they are twice as wide")
                .within(64, 4096),
        },
        "",
        {},
        nullptr};
    return table;
}

}  // namespace

const Structure& water_schema() {
    static const Structure table{
        "water",
        {
            structure<&Water::surface>("surface", surface_schema(),
                                       "the moving surface; its rest plane is y = 0")
                .required(),
            structure<&Water::extent>("extent", extent_schema(),
                                      "the rectangle of water that light is traced through"),
            integral<&Water::mesh_cells>(
                "mesh_cells", FieldKind::integer,
                "cells of the mesh along x; 0: 25 a shortest wave, at most 2.1 M triangles")
                .within(0, kMost),
            structure<&Water::rings>(
                "rings", rings_schema(),
                "in place of mesh_cells, for open water to the horizon: the mesh as nested squares about the "
                "camera; waves shorter than 4 cells are left out; not given: a regular grid"),
            number<&Water::refractive_index>("refractive_index", Dimension::number,
                                             "of the water against air")
                .within(1, 3),
            number<&Water::dispersion>(
                "dispersion", Dimension::number,
                "index at 450 nm less that at 650 nm, for caustics: blue has half of it more, red half less")
                .within(0, 0.2),
            choice<&Water::jerlov>("jerlov",
                                   {"none", "I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"},
                                   "optical water type, clear ocean to turbid coast, that absorption and "
                                   "scattering are taken from where they are not given"),
            number<&Water::absorption>("absorption", Dimension::per_length, "red, green, blue")
                .at_least(0)
                .one_for_all(),
            number<&Water::scattering>("scattering", Dimension::per_length, "red, green, blue")
                .at_least(0)
                .one_for_all(),
            structure<&Water::phase>("phase", phase_schema(), "of the scattering; not given: isotropic"),
            number<&Water::diffuse_attenuation>(
                "diffuse_attenuation", Dimension::per_length,
                "K_d of the sky's light, red, green, blue; not given: as absorption")
                .at_least(0)
                .one_for_all()
                .no_default(),
        },
        "",
        {},
        &derive_water};
    return table;
}

}  // namespace dapple::scene
