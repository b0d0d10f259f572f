#version 460
#extension GL_GOOGLE_include_directive : require
// What is told of each pixel's nearest drop, into an image of a host's: its motion or its depth. A pixel without a drop
// keeps what it holds. See src/passes/told.rs.
#include "frame.glsl"

// As layers.comp writes it: depth as bits, motion, number.
layout(std430, set = 0, binding = 1) readonly buffer Nearest { uvec4 nearest[]; };
layout(push_constant) uniform ToldPush {
    vec2 pixel;    // a pixel to the right and one down in the image's unit
    uint is_depth; // 1: depth, 0: motion
} push;

layout(location = 0) out vec4 told;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uvec4 drop = nearest[at.y * frame.window.z + at.x];
    // No drop has number 0.
    if (drop.z == 0u) discard;
    told = push.is_depth != 0u ? vec4(uintBitsToFloat(drop.x), 0.0, 0.0, 1.0)
                               : vec4(push.pixel * unpackHalf2x16(drop.y), 0.0, 1.0);
}
