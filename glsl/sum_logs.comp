#version 460
// Fewer sums of the sums of log luminance: each invocation sums a stride of them.

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SUMS = 1; // number of sums; the results follow them

layout(std430, set = 0, binding = 2) buffer Sums { float sums[]; };

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    float sum = 0.0;
    for (uint at = i; at < SUMS; at += stride) sum += sums[at];
    sums[SUMS + i] = sum;
}
