#version 460
// The overlay's triangles: indices and vertices read from buffers, in points from the upper left.

layout(std430, set = 0, binding = 1) readonly buffer Indices { uint indices[]; };
layout(std430, set = 0, binding = 2) readonly buffer Vertices { uint vertices[]; }; // x, y, u, v, RGBA

layout(push_constant) uniform Push { vec2 size_points; };

layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 tint; // premultiplied, encoded

void main() {
    uint at = 5u * indices[gl_VertexIndex];
    vec2 place = vec2(uintBitsToFloat(vertices[at]), uintBitsToFloat(vertices[at + 1u]));
    uv = vec2(uintBitsToFloat(vertices[at + 2u]), uintBitsToFloat(vertices[at + 3u]));
    tint = unpackUnorm4x8(vertices[at + 4u]);
    gl_Position = vec4(2.0 * place / size_points - 1.0, 0.0, 1.0);
}
