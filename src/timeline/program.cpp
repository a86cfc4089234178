#include "timeline/program.h"

namespace dapple::timeline {
namespace {

void visit_structure(const scene::Structure& structure, void* object, const std::string& path,
                     const FieldVisitor& visit) {
    const std::string_view type = type_of(structure, object);
    for (const scene::Field& field : structure.fields) {
        if (structure.find(field.key, type) != &field) continue;
        const std::string key_path = join(path, field.key);
        visit(field, object, key_path);
        if (field.kind == scene::FieldKind::structure && (field.present == nullptr || field.present(object)))
            visit_structure(*field.structure, field.member(object), key_path, visit);
        if (field.kind == scene::FieldKind::list)
            for (std::size_t i = 0; i < field.size(object); ++i)
                visit_structure(*field.structure, field.element(object, i), join(key_path, i), visit);
    }
}

}  // namespace

void* resolve(scene::FrameState& state, const Address& address) {
    void* object = &state;
    for (const Step& step : address)
        object = step.field->kind == scene::FieldKind::list ? step.field->element(object, step.index)
                                                            : step.field->member(object);
    return object;
}

double time_of_frame(const scene::Clip& clip, double frame) {
    const double frames = frame - static_cast<double>(clip.first_frame);
    return frames * static_cast<double>(clip.fps.denominator) / static_cast<double>(clip.fps.numerator);
}

scene::FrameState evaluate(const Program& program, std::int64_t frame) {
    scene::FrameState state = program.base;
    state.frame = frame;
    state.time = time_of_frame(state.clip, static_cast<double>(frame));
    for (const Track& track : program.tracks) {
        const Values values = track.curve.at(state.time);
        const scene::Components numbers = track.field->components(resolve(state, track.owner));
        for (std::size_t c = 0; c < numbers.size(); ++c)
            if (numbers[c] != nullptr) *numbers[c] = values[c];
    }
    for (const Derivation& derivation : program.derivations)
        derivation.structure->derive(resolve(state, derivation.owner), derivation.given);
    return state;
}

std::string join(const std::string& parent, std::string_view key) {
    return parent.empty() ? std::string(key) : (parent + '.').append(key);
}

std::string join(const std::string& list, std::size_t index) {
    return list + '[' + std::to_string(index) + ']';
}

std::string_view type_of(const scene::Structure& structure, const void* object) {
    if (structure.type_key.empty()) return {};
    const scene::Field* field = structure.find(structure.type_key, {});
    return field->choices[static_cast<std::size_t>(field->get(object))];
}

void visit_fields(scene::FrameState& state, const FieldVisitor& visit) {
    visit_structure(scene::frame_schema(), &state, "", visit);
}

}  // namespace dapple::timeline
