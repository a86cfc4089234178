#include "scene/schema.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scene/medium_schema.h"
#include "scene/schema_builder.h"

namespace dapple::scene {
namespace {

using namespace build;

constexpr double kMost = 2147483647;            // cells, photons: what fits an int
constexpr double kMostPixels = 16384;           // along a side: what Vulkan devices and picture readers take
constexpr double kMostSeed = 9007199254740992;  // 2^53
constexpr std::array<std::string_view, 3> kCausticMethods{"sliced_beams", "photon_splatting", "reference"};

bool has(const std::vector<std::string_view>& given, std::string_view key) {
    return std::find(given.begin(), given.end(), key) != given.end();
}

/// A vector of length 0 stays: checks find it where the timeline is read.
glm::dvec3 direction_of(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : v;
}

void derive_light(void* object, const std::vector<std::string_view>& given) {
    auto& light = *static_cast<Light*>(object);
    if (has(given, "elevation"))
        light.direction = sun_direction(light.elevation, light.azimuth);
    else if (has(given, "target"))
        light.direction = direction_of(light.target - light.position);
    else
        light.direction = direction_of(light.direction);
}

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

const Structure& light_schema() {
    const double right_angle = radians_from_degrees(90);
    static const Structure table{
        "light",
        {
            member<&Light::name>("name", FieldKind::text, "for --set and messages"),
            choice<&Light::type>("type", {"sun", "point", "spot"}, "what kind of light").required(),
            number<&Light::elevation>("elevation", Dimension::angle,
                                      "height above the horizon; 90 deg is overhead")
                .range({0, right_angle, true, false})
                .no_default()
                .only_for({"sun"}),
            number<&Light::azimuth>("azimuth", Dimension::angle,
                                    "where the sun stands: 0 is +x, 90 deg is +z")
                .only_for({"sun"}),
            number<&Light::direction>("direction", Dimension::number, "in which the light travels")
                .no_default()
                .only_for({"sun", "spot"}),
            number<&Light::target>("target", Dimension::length,
                                   "point that the spot shines at, for direction")
                .no_default()
                .only_for({"spot"}),
            number<&Light::irradiance>("irradiance", Dimension::irradiance, "on a plane that faces the sun")
                .at_least(0)
                .one_for_all()
                .only_for({"sun"}),
            number<&Light::angular_diameter>("angular_diameter", Dimension::angle,
                                             "of the sun's disc; 0: directional")
                .range({0, right_angle, false, true})
                .only_for({"sun"}),
            number<&Light::position>("position", Dimension::length, "where the light stands")
                .only_for({"point", "spot"}),
            number<&Light::intensity>("intensity", Dimension::intensity, "of a spot: on its axis")
                .at_least(0)
                .one_for_all()
                .only_for({"point", "spot"}),
            number<&Light::cone_angle>("cone_angle", Dimension::angle,
                                       "from the axis to where the light ends")
                .range({0, right_angle, true, false})
                .only_for({"spot"}),
            number<&Light::falloff_angle>("falloff_angle", Dimension::angle,
                                          "width of the soft edge inside the cone")
                .range({0, right_angle, false, false})
                .only_for({"spot"}),
        },
        "type",
        {{"sun", {{"elevation", "azimuth"}, {"direction"}}}, {"spot", {{"direction"}, {"target"}}}},
        &derive_light};
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
            structure<&Object::material>("material", material_schema(), "diffuse, or a mirror"),
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

const Structure& caustics_schema() {
    constexpr auto splatting = &Caustics::photon_splatting;
    static const Structure table{
        "caustics",
        {
            caustic_method(),
            choice<&Caustics::volume_resolution>(
                "volume_resolution", {"full", "half"},
                "pixels for which light scattered by media is computed; half: every second, each way"),
            integral<splatting, &PhotonSplattingParameters::map_resolution>(
                "map_resolution", FieldKind::integer, "photons along the longer side of the water's extent")
                .within(1, kMost)
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
            list<&FrameState::lights>("lights", light_schema(), "suns, points and spots"),
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
