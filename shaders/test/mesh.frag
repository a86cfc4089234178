#version 460
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 position_target;
layout(location = 1) out vec4 normal_target;

void main() {
    position_target = vec4(position, 1.0);
    normal_target = vec4(normal, 0.0);
}
