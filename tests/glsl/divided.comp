#version 460
#extension GL_GOOGLE_include_directive : require
// Quotients and remainders of two words; see tests/drawn/divided.rs.
#include "divided.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Found { vec4 found[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= given.length()) return;
    found[at] = uintBitsToFloat(uvec4(divided(floatBitsToUint(given[at].x), floatBitsToUint(given[at].y)), 0u, 0u));
}
