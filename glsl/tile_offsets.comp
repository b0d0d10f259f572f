#version 460
#extension GL_GOOGLE_include_directive : require
// Gives every tile its part of the entries, and every slab its part of that; one invocation a tile.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint SLABS = 1;

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uint count = 0u;
    for (uint slab = 0u; slab < SLABS; ++slab) {
        count += slabs[tile * SLABS + slab] + big_slabs[tile * SLABS + slab];
    }
    // Where a tile's entries lie does not matter, so no prefix sum is needed.
    uint first = atomicAdd(totals.entries, count);
    tiles[tile] = uvec2(first, count);
    for (uint slab = 0u; slab < SLABS; ++slab) {
        uint at = tile * SLABS + slab, few = slabs[at], many = big_slabs[at];
        slabs[at] = first;
        big_slabs[at] = first + few;
        first += few + many;
    }
}
