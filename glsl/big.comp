#version 460
#extension GL_GOOGLE_include_directive : require
// Gives the drops that touch many tiles, a few in a thousand, their blocks; one workgroup a drop.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "bigs.glsl"

layout(local_size_x = 32) in;

void main() {
    for (uint b = gl_WorkGroupID.x; b < totals.bigs; b += gl_NumWorkGroups.x) {
        uvec2 big = bigs[b];
        uint first = larges[big.x].first_block;
        for (uint i = gl_LocalInvocationID.x; i < big.y; i += gl_WorkGroupSize.x) {
            blocks[first + i] = big.x;
        }
    }
}
