#version 460
#extension GL_GOOGLE_include_directive : require
// The nearest whole numbers of four, and two of them as shares; see tests/drawn/rounded.rs.
#include "rounded.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Found { vec4 found[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= given.length()) return;
    vec4 by_four = rounded(given[at]);
    found[at] = vec4(by_four.x, rounded(given[at].zw).y, by_four.y, uintBitsToFloat(pack_shares(given[at].xy)));
}
