#version 460
#extension GL_EXT_scalar_block_layout : require
// Square points about pixel positions.
struct Sprite {
    vec2 position;  // pixels from the top left
    float width;    // pixels
    vec4 color;
};
layout(scalar, binding = 0) readonly buffer Sprites { Sprite sprites[]; };
layout(scalar, push_constant) uniform Push { vec2 size; };  // of the target, pixels
layout(location = 0) flat out vec4 color;

void main() {
    Sprite sprite = sprites[gl_VertexIndex];
    gl_Position = vec4(sprite.position / size * 2.0 - 1.0, 0.0, 1.0);
    gl_PointSize = sprite.width;
    color = sprite.color;
}
