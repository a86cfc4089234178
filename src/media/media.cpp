#include "media/media.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "media/phase.h"

namespace dapple::media {
namespace {

/// No water is above that, m relative to the frame's origin.
double highest_water(const scene::FrameScene& scene) {
    if (!scene.water) return std::numeric_limits<double>::infinity();
    return scene.water->largest_height - scene.origin.y;
}

/// Extinction without 0 times infinity.
glm::dvec3 depth_of(const glm::dvec3& extinction, double length) {
    glm::dvec3 depth(0);
    for (int c = 0; c < 3; ++c)
        if (extinction[c] > 0) depth[c] = extinction[c] * length;
    return depth;
}

/// The pieces of one component along a segment, in order.
struct Track {
    std::size_t component;
    const Body* body;
    std::vector<Piece> pieces;
    std::size_t next = 0;  ///< the first piece that ends after the place that has been reached
};

/// Adds the ends of pieces to places from 0 to the segment's length, in order, each once.
void add_places(const std::vector<Piece>& pieces, std::vector<double>& places) {
    const auto before = static_cast<std::ptrdiff_t>(places.size());
    for (const Piece& piece : pieces) {
        places.push_back(piece.begin);
        places.push_back(piece.end);
    }
    std::inplace_merge(places.begin(), places.begin() + before, places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
}

}  // namespace

struct Media::State {
    std::vector<Component> components;
    std::vector<Phase> phases;
    std::vector<Part> parts;
    bool bounded[2] = {false, false};  ///< in the air, in the water
    bool scatters[2] = {false, false};
};

Media::Media(const scene::FrameScene& scene) : state_(std::make_unique<State>()) {
    static const scene::PhaseFunction no_phase;
    const scene::FrameState& frame = scene.state;
    Component water;
    water.phase = &no_phase;
    if (frame.water) {
        water.extinction = frame.water->extinction();
        water.scattering = frame.water->scattering;
        water.phase = &frame.water->phase;
        state_->scatters[1] = water.scattering != glm::dvec3(0);
    }
    state_->components.push_back(water);
    for (std::size_t i = 0; i < frame.media.size(); ++i) {
        const scene::Medium& medium = frame.media[i];
        state_->components.push_back({medium.extinction, medium.extinction * medium.albedo, &medium.phase});
        if (Body::is_empty(scene, i)) continue;
        Part part{i + 1, medium.side != scene::MediumSide::water,
                  frame.water && medium.side != scene::MediumSide::air, Body(scene, i)};
        part.in_water &= part.body.least_y() <= highest_water(scene);
        for (const bool side : {false, true}) {
            state_->bounded[side] |= part.on(side);
            state_->scatters[side] |= part.on(side) && state_->components.back().scattering != glm::dvec3(0);
        }
        state_->parts.push_back(std::move(part));
    }
    for (const Component& component : state_->components) state_->phases.emplace_back(*component.phase);
}
Media::~Media() = default;

const std::vector<Component>& Media::components() const {
    return state_->components;
}
const std::vector<Part>& Media::parts() const {
    return state_->parts;
}
bool Media::bounded(bool in_water) const {
    return state_->bounded[in_water];
}
bool Media::scatters(bool in_water) const {
    return state_->scatters[in_water];
}

bool Media::may_meet(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                     bool in_water) const {
    return std::any_of(state_->parts.begin(), state_->parts.end(), [&](const Part& part) {
        return part.on(in_water) && !part.body.overlap(origin, direction, length).empty();
    });
}

glm::dvec3 Media::optical_depth(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                                bool in_water) const {
    glm::dvec3 depth = in_water ? depth_of(state_->components[0].extinction, length) : glm::dvec3(0);
    if (!state_->bounded[in_water]) return depth;
    for (const Part& part : state_->parts) {
        if (!part.on(in_water)) continue;
        const Interval overlap = part.body.overlap(origin, direction, length);
        if (overlap.empty()) continue;
        depth += part.body.column(origin, direction, overlap) * state_->components[part.component].extinction;
    }
    return depth;
}

double Media::density(std::size_t component, const glm::dvec3& position, bool in_water) const {
    if (component == 0) return in_water ? 1 : 0;
    for (const Part& part : state_->parts)
        if (part.component == component && part.on(in_water)) return part.body.density(position);
    return 0;
}

DensityProfile::Parabola DensityProfile::parabola(std::size_t piece, std::size_t component) const {
    const std::size_t entry = piece * components + component;
    const auto begin = static_cast<double>(density[entry]), half_way = static_cast<double>(middle[entry]);
    const double mean = (column[entry + components] - column[entry]) / (place[piece + 1] - place[piece]);
    return {begin, half_way, std::max(0.0, 6 * mean - begin - 4 * half_way)};  // Simpson's rule is exact
}

double DensityProfile::column_to(std::size_t piece, std::size_t component, double s) const {
    const double before = column[piece * components + component];
    const double height = place[piece + 1] - place[piece];
    if (!(height > 0)) return before;
    return before + height * parabola(piece, component).column((s - place[piece]) / height);
}

DensityProfile Media::profile(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                              bool in_water) const {
    DensityProfile profile;
    const std::size_t components = profile.components = state_->components.size();
    profile.place = {0, length};
    std::vector<Track> tracks;
    for (const Part& part : state_->parts) {
        if (!part.on(in_water)) continue;
        const Interval overlap = part.body.overlap(origin, direction, length);
        if (overlap.empty()) continue;
        Track& track = tracks.emplace_back(Track{part.component, &part.body, {}});
        part.body.append_pieces(origin, direction, overlap, track.pieces);
        add_places(track.pieces, profile.place);
    }
    const std::size_t places = profile.place.size();
    profile.density.assign(places * components, 0);
    profile.middle.assign(places * components, 0);
    profile.column.assign(places * components, 0);
    if (in_water) {
        for (std::size_t i = 0; i < places; ++i) {
            profile.density[i * components] = profile.middle[i * components] = 1;
            profile.column[i * components] = profile.place[i];
        }
    }
    for (Track& track : tracks) {
        const auto density_at = [&](double t) { return track.body->density(origin + t * direction); };
        double column = 0;
        for (std::size_t i = 0; i < places; ++i) {
            const std::size_t entry = i * components + track.component;
            const double begin = profile.place[i];
            profile.column[entry] = column;
            while (track.next < track.pieces.size() && track.pieces[track.next].end <= begin) ++track.next;
            if (track.next == track.pieces.size()) continue;
            const Piece& piece = track.pieces[track.next];
            if (i + 1 == places || piece.begin > begin) continue;
            // Places of other components part a piece further.
            Piece part = piece;
            part.begin = begin;
            part.end = profile.place[i + 1];
            if (part.begin > piece.begin) part.first = density_at(part.begin);
            if (part.end < piece.end) part.last = density_at(part.end);
            if (part.begin > piece.begin || part.end < piece.end)
                part.middle = density_at(0.5 * (part.begin + part.end));
            profile.density[entry] = static_cast<float>(part.first);
            profile.middle[entry] = static_cast<float>(part.middle);
            column += part.column();
        }
        // The last place has no part after it: what the last part ended with.
        if (!track.pieces.empty() && track.pieces.back().end == profile.place.back())
            profile.density[(places - 1) * components + track.component] =
                static_cast<float>(track.pieces.back().last);
    }
    return profile;
}

double Media::phase(std::size_t component, double cosine) const {
    return state_->phases[component].at(cosine);
}

}  // namespace dapple::media
