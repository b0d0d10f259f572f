#version 460
#extension GL_GOOGLE_include_directive : require
// The bits of four halves; see tests/drawn/rounded.rs.
#include "rounded.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Found { vec4 found[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at < given.length()) found[at] = vec4(half_bits(given[at]));
}
