#version 460
#extension GL_GOOGLE_include_directive : require
// The texel of a direction, that texel's direction, and the basis about it; see tests/octahedron.rs.
#include "octahedron.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) readonly buffer Directions { vec4 directions[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Found { vec4 found[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= directions.length()) return;
    uint texel = direction_texel(directions[at].xyz);
    vec3 n = texel_direction(texel), u, v;
    basis(n, u, v);
    found[3u * at] = vec4(n, float(texel));
    found[3u * at + 1u] = vec4(u, 0.0);
    found[3u * at + 2u] = vec4(v, 0.0);
}
