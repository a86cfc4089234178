#version 460
layout(location = 0) flat in vec4 color;
layout(location = 0) out vec4 first;
layout(location = 1) out uint pixel;

void main() {
    first = 2.0 * color;
    pixel = uint(gl_FragCoord.x) + 1000u * uint(gl_FragCoord.y);
}
