#version 460
#extension GL_GOOGLE_include_directive : require
// Fewer sums of sums of log luminance: each invocation sums a stride of them. src/passes/tone_map.rs says how often.
#include "by_texels.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 2) buffer Sums { float sums[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer sum_words;
layout(push_constant) uniform LogSumsPush {
    uint first, count; // of the sums that are read
    uint to;           // the first of those that are written, one an invocation
} push;

float sum_at(uint at) {
    return BY_TEXELS != 0u ? uintBitsToFloat(texelFetch(sum_words, int(at)).x) : sums[at];
}

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    float sum = 0.0;
    for (uint at = i; at < push.count; at += stride) sum += sum_at(push.first + at);
    sums[push.to + i] = sum;
}
