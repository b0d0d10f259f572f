#version 460
#extension GL_GOOGLE_include_directive : require
// Motion, depth or (NUMBER) number of each pixel's nearest drop, into an image of a host's. A pixel without a drop keeps what it holds. See
// src/passes/motion_depth.rs.
#include "frame.glsl"

// nearest.glsl and drop_records.glsl say what they hold.
layout(std430, set = 0, binding = 1) readonly buffer NearestDrops { uvec2 nearest_drops[]; };
layout(std430, set = 0, binding = 2) readonly buffer DropRecords { uvec4 drop_records[]; };
layout(push_constant) uniform MotionDepthPush {
    vec2 pixel;    // a pixel to the right and one down in the image's unit
    uint is_depth; // 1: depth, 0: motion
} push;

#ifdef NUMBER
layout(location = 0) out uvec4 texel;
#else
layout(location = 0) out vec4 texel;
#endif

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint number = nearest_drops[at.y * frame.window.z + at.x].x;
    if (number == END) discard;
    uvec4 record = drop_records[number];
#ifdef NUMBER
    texel = uvec4(record.zw, 0u, 0u);
#else
    texel = push.is_depth != 0u ? vec4(uintBitsToFloat(record.x), 0.0, 0.0, 1.0)
                                : vec4(push.pixel * unpackHalf2x16(record.y), 0.0, 1.0);
#endif
}
