#version 460
#extension GL_GOOGLE_include_directive : require
// The rotation of a drop's mask as drops_point.vert and drops_quad.vert have it; see tests/rotation.rs.
#include "frame.glsl"
#include "sprite.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) readonly buffer Drops { vec4 drops[]; }; // centre in view space, radius
layout(std430, set = 0, binding = 2) writeonly buffer Columns { vec4 columns[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= drops.length()) return;
    mat3 rotation = sprite(drops[at].xyz, drops[at].w).rotation;
    for (uint i = 0u; i < 3u; ++i) columns[3u * at + i] = vec4(rotation[i], 0.0);
}
