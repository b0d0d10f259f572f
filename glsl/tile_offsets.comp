#version 460
#extension GL_GOOGLE_include_directive : require
// Gives every tile its part of the entries, and every slab its part of that; one invocation a tile.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint MAX_RECORDS = 1;

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile == 0u) {
        uint records = min(totals.records, MAX_RECORDS);
        totals.fill_groups = uvec4((records + 255u) / 256u, 1u, 1u, 0u);
    }
    if (tile >= TILE_COUNT) return;
    uint count = 0u;
    for (uint slab = 0u; slab < SLABS; ++slab) {
        count += slab_small[tile * SLABS + slab] + slab_wide[tile * SLABS + slab];
    }
    // Where a tile's entries lie does not matter, so no prefix sum is needed.
    uint first = atomicAdd(totals.entries, count);
    tiles[tile] = uvec2(first, count);
    for (uint slab = 0u; slab < SLABS; ++slab) {
        uint at = tile * SLABS + slab;
        uint small = slab_small[at], wide = slab_wide[at];
        slab_small[at] = first;
        slab_wide[at] = first + small;
        first += small + wide;
    }
}
