#version 460
#extension GL_GOOGLE_include_directive : require
// Copies every member of `Frame`, by name and in the order of its declaration, to a buffer; see
// tests/frame_layout.rs.
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 2) writeonly buffer Copies { uvec4 copies[]; };

void main() {
    if (gl_GlobalInvocationID.x > 0u) return;
    copies[0] = floatBitsToUint(frame.right);
    copies[1] = floatBitsToUint(frame.up);
    copies[2] = floatBitsToUint(frame.back);
    copies[3] = floatBitsToUint(frame.units);
    copies[4] = frame.camera_place;
    copies[5] = frame.shift;
    copies[6] = frame.seed;
    copies[7] = floatBitsToUint(frame.motion);
    copies[8] = floatBitsToUint(frame.camera_high);
    copies[9] = floatBitsToUint(frame.camera_low);
    copies[10] = floatBitsToUint(frame.extent);
    copies[11] = floatBitsToUint(frame.image);
    copies[12] = frame.window;
    copies[13] = floatBitsToUint(frame.principal);
    copies[14] = floatBitsToUint(frame.frustum_x);
    copies[15] = floatBitsToUint(frame.frustum_y);
    copies[16] = floatBitsToUint(frame.environment);
    copies[17] = floatBitsToUint(frame.tone);
    copies[18] = frame.tiles;
    copies[19] = frame.room;
    copies[20] = frame.clusters;
    copies[21] = floatBitsToUint(frame.moved);
    copies[22] = frame.streaks;
    copies[23] = floatBitsToUint(frame.lens);
}
