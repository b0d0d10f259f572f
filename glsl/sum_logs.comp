#version 460
// Fewer sums of sums of log luminance: each invocation sums a stride of them. src/passes/tone_map.rs says how often.

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 2) buffer Sums { float sums[]; };
layout(push_constant) uniform LogSumsPush {
    uint first, count; // of the sums that are read
    uint to;           // the first of those that are written, one an invocation
} push;

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    float sum = 0.0;
    for (uint at = i; at < push.count; at += stride) sum += sums[push.first + at];
    sums[push.to + i] = sum;
}
