#version 460
#extension GL_GOOGLE_include_directive : require
// The drops that touch many tiles, a few in a thousand: enters each into the lists of the tiles that
// its cone meets; one workgroup a drop. Runs twice: to count, then to fill.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 32) in;
layout(constant_id = 0) const uint FILL = 0;
layout(constant_id = 1) const uint MAX_ENTRIES = 1;
layout(constant_id = 2) const uint MAX_BLOCKS = 1;
layout(constant_id = 3) const uint SLABS = 1;

#define COUNTERS_BINDING 16
#include "counters.glsl"
#include "tile_entry.glsl"

// Does the drop's outline, grown by a tile, meet the tile?
bool meets(Record r, uvec2 tile) {
    vec2 middle = (vec2(tile) + 0.5) * vec2(TILE), m = middle - r.center;
    vec2 st = r.to_disc.xy * m.x + r.to_disc.zw * m.y;
    // Half a tile's diagonal and the smoothing, stretched at most by the norm of the matrix.
    float reach = 0.5 * length(vec2(TILE)) + 1.0;
    vec4 d = r.to_disc;
    return length(st) <= 1.0 + reach * length(vec2(length(d.xy), length(d.zw)));
}

void main() {
    uint record = bigs[gl_WorkGroupID.x];
    uvec2 bin = uvec2(bins[record * BIN_WORDS], bins[record * BIN_WORDS + 1u]);
    uvec2 first = uvec2(bin.x & 0xffffu, bin.x >> 16);
    uvec2 count = uvec2(bin.y & 0xffffu, bin.y >> 16);
    Record r = records[record];
    uint slab = slab_of(r.distance2, SLABS);
    bool rays = (r.look & BY_RAYS) != 0u;
    for (uint i = gl_LocalInvocationID.x; i < count.x * count.y; i += gl_WorkGroupSize.x) {
        uvec2 at = first + uvec2(i % count.x, i / count.x);
        uint tile = at.y * tiles_across() + at.x, slot = tile * SLABS + slab;
        if (!meets(r, at)) continue;
        uint place = atomicAdd(big_slabs[slot], 1u);
        if (FILL != 0u) enter(place, tile, record, r.distance2, rays);
    }
}
