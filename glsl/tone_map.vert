#version 460
#extension GL_GOOGLE_include_directive : require
// One triangle over the whole image; where the exposure is not fixed, it sums up the log average on the way,
// three times in all.
#include "frame.glsl"

layout(constant_id = 0) const uint FINAL_SUMS = 1; // sums of the second stage, after those of the first

layout(std430, set = 0, binding = 2) readonly buffer Sums { float sums[]; };
layout(location = 0) flat out float exposure;
layout(location = 1) flat out uint width; // of the picture

void main() {
    vec2 place = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
    width = frame.window.z;
    exposure = frame.tone.z;
    if (exposure == 0.0) {
        float sum = 0.0;
        for (uint at = 0u; at < FINAL_SUMS; ++at) sum += sums[frame.tiles.x + at];
        exposure = frame.tone.x / exp(sum / frame.tone.w);
    }
}
