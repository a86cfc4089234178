#include "light/water_beams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/parallel.h"
#include "light/beam_axes.h"
#include "light/beam_flux.h"
#include "light/map_plan.h"
#include "light/spot_picture.h"
#include "light/wave_shadow.h"
#include "media/media.h"

namespace dapple::light {
namespace {

/// A channel that is traced by itself, or all.
struct Band {
    const char* name = "";
    glm::dvec3 mask{1, 1, 1};
    double index_shift = 0;
    int channel = 1;  // whose extinction before the surface it has
    bool counts_paths = true;
};
constexpr std::array<const char*, kSheetAxes> kAxisNames = {"", " +x", " -x", " +z", " -z", " +y", " -y"};

/// By how much the refractive index of blue is greater than that of red, where that parts their ways.
double dispersion_of(const scene::Water& water, Event event) {
    return event == Event::transmission ? water.dispersion : 0;
}

/// One band where all channels go the same ways: without dispersion, and `dimmed_alike` before the surface.
std::vector<Band> bands_of(double dispersion, bool dimmed_alike) {
    if (!(dispersion > 0) && dimmed_alike) return {{}};
    const bool named = dispersion > 0;
    return {{named ? " red" : "", {1, 0, 0}, -0.5 * dispersion, 0, false},
            {named ? " green" : "", {0, 1, 0}, 0, 1, true},
            {named ? " blue" : "", {0, 0, 1}, 0.5 * dispersion, 2, false}};
}

/// What light meets between its source and the water.
struct WayToWater {
    glm::dvec3 extinction{0};                  ///< /m, of the water about a lamp
    std::array<std::vector<float>, 3> depths;  ///< a vertex of the mesh; empty where there is the water only
    bool alike = true;                         ///< for all channels
};

WayToWater way_to_water(const scene::FrameScene& scene, const media::Media& media, const WaterLight& light) {
    WayToWater way;
    if (!media.bounded(light.from_below)) {
        if (light.from_below) way.extinction = scene.state.water->extinction();
        way.alike = way.extinction == glm::dvec3(way.extinction.g);
        return way;
    }
    constexpr std::size_t kTile = 1 << 12;
    const std::vector<glm::dvec3>& positions = scene.water->mesh.positions;
    for (std::vector<float>& channel : way.depths) channel.resize(positions.size());
    std::vector<std::uint8_t> alike(positions.size() / kTile + 1, 1);
    parallel_for(positions.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            glm::dvec3 back = -light.direction;
            double length = std::numeric_limits<double>::infinity();
            if (light.type != scene::LightType::sun) {
                back = light.position - positions[v];
                length = glm::length(back);
                back /= length;
            }
            const glm::dvec3 depth =
                media.optical_depth(positions[v] - scene.origin, back, length, light.from_below);
            for (int c = 0; c < 3; ++c)
                way.depths[static_cast<std::size_t>(c)][v] = static_cast<float>(depth[c]);
            // Written so that what is no number is alike.
            if (std::abs(depth.r - depth.g) > 0 || std::abs(depth.b - depth.g) > 0) alike[begin / kTile] = 0;
        }
    });
    way.alike = std::find(alike.begin(), alike.end(), 0) == alike.end();
    return way;
}

/// What all sheets of a chain have in common.
struct ChainSetup {
    scene::Light light;
    Event event = Event::transmission;
    int sun_samples = 1;
    double disc_radius = 0;     ///< rad, of one part of the sun's disc
    glm::dvec3 color{0, 0, 0};  ///< of one part
    WaterLight water_light;     ///< its direction is that of the part
};

ChainSetup chain_setup(const scene::FrameScene& scene, Chain chain, int sun_samples) {
    ChainSetup setup;
    setup.light = scene.state.lights[static_cast<std::size_t>(chain.light)];
    setup.event = chain.event;
    const scene::Light& light = setup.light;
    setup.water_light = {.type = light.type, .direction = light.direction, .position = light.position};
    if (light.type == scene::LightType::sun) {
        setup.sun_samples = light.angular_diameter > 0 ? std::max(1, sun_samples) : 1;
        setup.disc_radius = std::tan(0.5 * light.angular_diameter) / std::sqrt(setup.sun_samples);
        setup.color = light.irradiance / static_cast<double>(setup.sun_samples);
        return setup;
    }
    setup.color = light.intensity;
    setup.water_light.from_below = light.position.y < 0;
    if (light.type == scene::LightType::spot) {
        setup.water_light.cos_outer = std::cos(light.cone_angle);
        setup.water_light.cos_inner = std::cos(std::max(0.0, light.cone_angle - light.falloff_angle));
    }
    return setup;
}

/// Sheets of channels that go the same ways, as one for each axis, tinted. `color`: of them all. A channel
/// may lack sheets that it has no flux in.
template <class Real>
std::vector<BeamSheet<Real>> tinted(std::span<std::vector<BeamSheet<Real>>> channels,
                                    const glm::dvec3& color) {
    const double all = color.r + color.g + color.b;
    const glm::dvec3 weights = all > 0 ? color / all : glm::dvec3(1.0 / 3);
    constexpr std::size_t kTile = 1 << 14;
    std::vector<BeamSheet<Real>> merged;
    for (int c = 0; c < 3; ++c) {
        for (BeamSheet<Real>& sheet : channels[static_cast<std::size_t>(c)]) {
            const std::vector<Real> flux = std::exchange(sheet.flux, {});
            const BeamLosses losses = std::exchange(sheet.losses, {}).scaled(weights[c]);
            const bool counts_paths = sheet.counts_paths;
            auto to = std::find_if(merged.begin(), merged.end(), [&](const BeamSheet<Real>& s) {
                return s.world_from_mesh == sheet.world_from_mesh;
            });
            if (to == merged.end()) {
                to = merged.insert(to, std::move(sheet));
                to->color = color;
                to->tint.assign(flux.size(), glm::vec<3, Real>(0));
            }
            to->counts_paths |= counts_paths;
            to->losses += losses;
            to->losses.unknown_facets = losses.unknown_facets;  // the same of all channels
            if (!(weights[c] > 0)) continue;
            parallel_for(flux.size(), kTile, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) to->tint[i][c] = flux[i];
            });
        }
    }
    const glm::vec<3, Real> shares(weights);
    for (BeamSheet<Real>& sheet : merged) {
        sheet.flux.resize(sheet.tint.size());
        parallel_for(sheet.flux.size(), kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                glm::vec<3, Real>& tint = sheet.tint[i];
                const Real flux = glm::dot(tint, shares);
                sheet.flux[i] = flux;
                if (flux > 0) tint /= flux;
            }
        });
    }
    return merged;
}

/// Traces the sheets of one direction and band and appends those that hold beams, the first in any case.
template <class Real>
class SheetTracer {
public:
    SheetTracer(const scene::FrameScene& scene, const rays::RayScene& rays, Chain chain,
                const ChainSetup& setup)
        : scene_(scene), rays_(rays), chain_(chain), setup_(setup) {}

    void trace(const WaterLight& light, const Band& band, const std::string& name,
               std::optional<std::vector<float>>& visible, std::vector<BeamSheet<Real>>& sheets) {
        const scene::Water& water = *scene_.state.water;
        const double index = water.refractive_index + band.index_shift;
        const double eta = light.from_below ? index : 1 / index;
        setup_.light.direction = light.direction;
        const auto axes = sheet_axes(mesh_axis(setup_.light, light.from_below, setup_.event, index));
        const std::size_t first = sheets.size();
        std::uint32_t wanted = 1;
        std::vector<std::uint8_t> crossings;
        for (int k = 0; k < kSheetAxes; ++k) {
            if (!(wanted >> k & 1)) continue;
            BeamSheet<Real>& sheet = sheets.emplace_back();
            sheet.name = name + band.name + kAxisNames[static_cast<std::size_t>(k)];
            sheet.light = chain_.light;
            sheet.event = setup_.event;
            sheet.from_below = light.from_below;
            sheet.counts_paths = band.counts_paths;
            sheet.color = setup_.color * band.mask;
            sheet.world_from_mesh = mesh_frame(axes[static_cast<std::size_t>(k)]);
            sheet.rows = scene_.water->rows;
            sheet.columns = scene_.water->columns;
            if (light.type == scene::LightType::sun) {
                sheet.light_direction = light.direction;
                const DiscEllipse ellipse = disc_ellipse(light.direction, setup_.disc_radius, setup_.event,
                                                         index, sheet.world_from_mesh);
                sheet.disc_u = ellipse.u;
                sheet.disc_v = ellipse.v;
            }
            trace_vertices(scene_, light, eta, axes, k, sheet, events_);
            FluxSurvey survey = fill(light, eta, k, visible, sheet);
            const bool may_hide = survey.faces_away || sheet.rows == 0;
            if (may_hide && !visible) {
                visible = visible_shares(scene_, rays_, light);
                survey = fill(light, eta, k, visible, sheet);
            }
            wanted |= survey.axes;
            if (sheets.size() == first + 1) sheet.losses = survey.losses;
            if (events_.flattest_squared <= survey.steepest_squared) {
                if (!steepness_) steepness_.emplace(scene_.water->mesh);
                sheet.losses.second_crossing =
                    second_crossing(scene_, rays_, light, sheet, *steepness_, crossings);
            }
        }
    }

private:
    FluxSurvey fill(const WaterLight& light, double eta, int axis,
                    const std::optional<std::vector<float>>& visible, BeamSheet<Real>& sheet) {
        static const std::vector<float> all;
        return fill_flux(scene_.water->mesh, light, eta, events_, visible ? *visible : all, axis, sheet);
    }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    Chain chain_;
    ChainSetup setup_;
    VertexEvents events_;
    std::optional<SteepnessMap> steepness_;  // once some ray is flatter than some triangle
};

template <class Real>
void count_losses(const std::vector<BeamSheet<Real>>& sheets, FrameStats& stats) {
    double unknown = 0;
    for (const BeamSheet<Real>& sheet : sheets) {
        const double mean = (sheet.color.r + sheet.color.g + sheet.color.b) / 3;
        const auto count = [&](const char* name, double flux) {
            if (flux > 0) stats.count(name, flux * mean);
        };
        count("lost to media before the surface, W", sheet.losses.absorbed);
        count("lost to wave shadow, W", sheet.losses.wave_shadow);
        count("lost to total reflection, W", sheet.losses.total_reflection);
        count("lost outside cones, W", sheet.losses.outside_cone);
        count("lost to normals not finite, W", sheet.losses.not_finite);
        count("meets the water again, W", sheet.losses.second_crossing);
        unknown = std::max(unknown, static_cast<double>(sheet.losses.unknown_facets));
    }
    if (unknown > 0) stats.count("facets not finite", unknown);
}

}  // namespace

BeamLosses& BeamLosses::operator+=(const BeamLosses& other) {
    absorbed += other.absorbed;
    wave_shadow += other.wave_shadow;
    total_reflection += other.total_reflection;
    outside_cone += other.outside_cone;
    not_finite += other.not_finite;
    unknown_facets += other.unknown_facets;
    second_crossing += other.second_crossing;
    return *this;
}

BeamLosses BeamLosses::scaled(double share) const {
    BeamLosses part = *this;
    for (double* const loss : {&part.absorbed, &part.wave_shadow, &part.total_reflection, &part.outside_cone,
                               &part.not_finite, &part.second_crossing})
        *loss *= share;
    return part;
}

template <class Real>
std::vector<BeamSheet<Real>> water_beams(const scene::FrameScene& scene, const rays::RayScene& rays,
                                         Chain chain, int sun_samples, FrameStats& stats) {
    const ScopedPass pass(stats, "beams");
    const ChainSetup setup = chain_setup(scene, chain, sun_samples);
    const bool sun = setup.light.type == scene::LightType::sun;
    std::vector<BeamSheet<Real>> sheets;
    if (scene.water->mesh.positions.empty() || (!sun && setup.light.position.y == 0)) return sheets;

    std::vector<glm::dvec3> directions = {setup.light.direction};
    if (sun) directions = sun_directions(setup.light, setup.sun_samples);
    const std::string name = chain_name(scene.state, chain);
    const media::Media media(scene);
    const SpotPicture picture(scene, chain.light);
    SheetTracer<Real> tracer(scene, rays, chain, setup);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        if (sun && !(directions[i].y < -kLowestSun)) continue;
        WaterLight light = setup.water_light;
        if (picture.exists()) light.picture = &picture;
        light.direction = directions[i];
        std::optional<std::vector<float>> visible;  // the same for all bands
        const bool first = sheets.empty();
        const WayToWater way = way_to_water(scene, media, light);
        const double dispersion = dispersion_of(*scene.state.water, setup.event);
        std::vector<std::vector<BeamSheet<Real>>> bands;
        for (Band band : bands_of(dispersion, way.alike && picture.grey())) {
            light.channel = band.channel;
            light.extinction = way.extinction[band.channel];
            light.depths = way.depths[static_cast<std::size_t>(band.channel)];
            band.counts_paths &= first;
            tracer.trace(light, band, directions.size() > 1 ? name + ' ' + std::to_string(i + 1) : name,
                         visible, bands.emplace_back());
        }
        if (bands.size() == 3 && !(dispersion > 0)) bands = {tinted<Real>(bands, setup.color)};
        for (std::vector<BeamSheet<Real>>& band : bands)
            sheets.insert(sheets.end(), std::make_move_iterator(band.begin()),
                          std::make_move_iterator(band.end()));
    }
    std::size_t beams = 0;
    for (const BeamSheet<Real>& sheet : sheets)
        beams += static_cast<std::size_t>(
            std::count_if(sheet.flux.begin(), sheet.flux.end(), [](Real flux) { return flux > 0; }));
    stats.count("beams", static_cast<double>(beams));
    count_losses(sheets, stats);
    return sheets;
}

bool may_tint(const scene::FrameState& state, const scene::Light& light) {
    const auto uneven = [](const glm::dvec3& extinction) { return extinction != glm::dvec3(extinction.g); };
    const bool from_below = light.type != scene::LightType::sun && light.position.y < 0;
    const scene::MediumSide other = from_below ? scene::MediumSide::air : scene::MediumSide::water;
    return !light.texture.empty() || (from_below && state.water && uneven(state.water->extinction())) ||
           std::any_of(state.media.begin(), state.media.end(), [&](const scene::Medium& medium) {
               return medium.side != other && medium.density > 0 && uneven(medium.extinction);
           });
}

template std::vector<BeamSheet<float>> water_beams(const scene::FrameScene&, const rays::RayScene&, Chain,
                                                   int, FrameStats&);
template std::vector<BeamSheet<double>> water_beams(const scene::FrameScene&, const rays::RayScene&, Chain,
                                                    int, FrameStats&);

}  // namespace dapple::light
