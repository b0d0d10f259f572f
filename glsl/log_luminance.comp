#version 460
#extension GL_GOOGLE_include_directive : require
// Sums of log(delta + luminance) over the image: each invocation sums a stride of pixels. No shared
// memory: barriers cost a CPU driver five times the work itself. sum_logs.comp goes on.
#include "frame.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1) uniform sampler2D radiance_image;
layout(std430, set = 0, binding = 2) writeonly buffer Sums { float sums[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    uvec2 size = frame.window.zw;
    float sum = 0.0;
    for (uint at = i; at < size.x * size.y; at += stride) {
        vec3 radiance = texelFetch(radiance_image, ivec2(at % size.x, at / size.x), 0).rgb;
        sum += log(frame.tone.y + dot(radiance, LUMINANCE));
    }
    sums[i] = sum;
}
