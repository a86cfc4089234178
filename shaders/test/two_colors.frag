#version 460
layout(location = 0) flat in vec4 color;
layout(location = 0) out vec4 first;
layout(location = 1) out vec4 second;

void main() { first = second = color; }
