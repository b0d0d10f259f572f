#version 460
#extension GL_GOOGLE_include_directive : require
// Sums of log(delta + luminance) over the image: each invocation sums a stride of pixels, then of
// sums. No shared memory: barriers cost a CPU driver five times the work itself.
#include "frame.glsl"
#include "radiance_source.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SUMS = 1; // number of sums of the first stage

layout(std430, set = 0, binding = 2) buffer Sums { float sums[]; };
layout(push_constant) uniform Push { uint stage; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

void main() {
    uint i = gl_GlobalInvocationID.x, stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    float sum = 0.0;
    if (stage == 0u) {
        uvec2 size = uvec2(frame.image.xy);
        for (uint at = i; at < size.x * size.y; at += stride) {
            vec3 radiance = radiance_at(uvec2(at % size.x, at / size.x));
            sum += log(frame.tone.y + dot(radiance, LUMINANCE));
        }
        sums[i] = sum;
    } else {
        for (uint at = i; at < SUMS; at += stride) sum += sums[at];
        sums[SUMS + i] = sum;
    }
}
