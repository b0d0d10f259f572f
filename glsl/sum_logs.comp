#version 460
#extension GL_GOOGLE_include_directive : require
// Fewer sums of the sums of log luminance: each invocation sums a stride of them.
#include "frame.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 2) buffer Sums { float sums[]; };

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    uint count = frame.tiles.x; // the results follow them
    float sum = 0.0;
    for (uint at = i; at < count; at += stride) sum += sums[at];
    sums[count + i] = sum;
}
