#version 460
#extension GL_GOOGLE_include_directive : require
// Sorts the drops of every slab of every tile front to back, by distance, then by index; one
// invocation a slab. Up to eight by Batcher's network in registers, more by insertion.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint MAX_ENTRIES = 1;
layout(constant_id = 2) const uint MAX_BLOCKS = 1;
layout(constant_id = 3) const uint SLABS = 1;

const uint BLOCKS_A_GROUP = 256u / PIXELS; // of rays.comp

// Blocks are numbered as they come, so between equal distances their drop decides, as elsewhere.
uint drop_of(uint what) {
    uint block = min(what & ~IS_BLOCK, MAX_BLOCKS - 1u);
    return (what & IS_BLOCK) != 0u ? record_index[blocks[block].x] : what;
}

bool after(uvec2 a, uvec2 b) {
    return a.x > b.x || a.x == b.x && a.y > b.y;
}

#define sort(a, b) if (after(e[a], e[b])) { uvec2 swap = e[a]; e[a] = e[b]; e[b] = swap; }

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot == 0u) {
        uint count = min(totals.blocks, MAX_BLOCKS);
        totals.block_groups = uvec4((count + BLOCKS_A_GROUP - 1u) / BLOCKS_A_GROUP, 1u, 1u, 0u);
    }
    if (slot >= TILE_COUNT * SLABS) return;
    uint first = slabs[slot], end = min(big_slabs[slot], MAX_ENTRIES);
    uint count = end > first ? end - first : 0u;

    uvec2 e[8];
    for (uint i = 0u; i < 8u; ++i) {
        e[i] = uvec2(0xffffffffu);
        if (i < count) e[i] = entries[first + i];
    }
    sort(0, 1); sort(2, 3); sort(4, 5); sort(6, 7);
    sort(0, 2); sort(1, 3); sort(4, 6); sort(5, 7);
    sort(1, 2); sort(5, 6);
    sort(0, 4); sort(1, 5); sort(2, 6); sort(3, 7);
    sort(2, 4); sort(3, 5);
    sort(1, 2); sort(3, 4); sort(5, 6);
    for (uint i = 0u; i < 8u; ++i) if (count <= 8u && i < count) entries[first + i] = e[i];

    uint last = count > 8u ? end : first;
    for (uint i = first + 1u; i < last; ++i) {
        uvec2 entry = entries[i];
        uint at = i;
        while (at > first) {
            uvec2 other = entries[at - 1u];
            if (!after(other, entry)) break;
            entries[at] = other;
            --at;
        }
        entries[at] = entry;
    }
}
