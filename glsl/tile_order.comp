#version 460
#extension GL_GOOGLE_include_directive : require
// Sorts every tile's drops front to back, by distance, then by index; one invocation a tile.
// The slabs have done most of it: an insertion sort moves an entry by a few places.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 32) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint MAX_ENTRIES = 1;

bool after(uvec2 a, uvec2 b) {
    bool result = a.x > b.x;
    for (bool once = a.x == b.x; once; once = false) {
        result = record_index[a.y] > record_index[b.y];
    }
    return result;
}

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uint first = tiles[tile].x, end = min(first + tiles[tile].y, MAX_ENTRIES);
    for (uint i = first + 1u; i < end; ++i) {
        uvec2 entry = entries[i];
        uint at = i;
        while (at > first) {
            uvec2 other = entries[at - 1u];
            if (!after(other, entry)) break;
            entries[at] = other;
            --at;
        }
        if (at < i) entries[at] = entry;
    }
}
