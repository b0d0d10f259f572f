#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the drops that touch few tiles into their lists; one invocation a record.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint MAX_ENTRIES = 1;
layout(constant_id = 1) const uint MAX_BLOCKS = 1;
layout(constant_id = 2) const uint MAX_RECORDS = 1;
layout(constant_id = 3) const uint SLABS = 1;
layout(constant_id = 4) const uint MAY_RAY = 0; // 1: so small a drop may be drawn by rays

#define COUNTERS_BINDING 16
#include "counters.glsl"
#include "tile_entry.glsl"

void main() {
    uint record = gl_GlobalInvocationID.x;
    if (record >= min(totals.records, MAX_RECORDS)) return;
    uint bin = record * BIN_WORDS, tiles_packed = bins[bin + 1u];
    uvec2 count = uvec2(tiles_packed & 0xffffu, tiles_packed >> 16);
    if (tiles_packed == 0u || count.x * count.y > MOST_TILES) return;
    uvec2 first = uvec2(bins[bin] & 0xffffu, bins[bin] >> 16);
    uint places[MOST_TILES / 2];
    for (uint w = 0u; w < MOST_TILES / 2u; ++w) places[w] = bins[bin + 2u + w];
    float distance2 = records[record].distance2;
    bool rays = MAY_RAY != 0u && (records[record].look & BY_RAYS) != 0u;
    uint slab = slab_of(distance2, SLABS), x = 0u, y = 0u, i = 0u;
    do {
        uint tile = (first.y + y) * tiles_across() + first.x + x, place = 0u;
        for (uint w = 0u; w < MOST_TILES / 2u; ++w) place |= i / 2u == w ? places[w] : 0u;
        place = place >> (16u * (i & 1u)) & 0xffffu;
        // 65,535 drops in one slab of one tile: no place was left.
        uint at = place < 0xffffu ? slabs[tile * SLABS + slab] + place : MAX_ENTRIES;
        enter(at, tile, record, distance2, rays);
        ++i;
        if (++x == count.x) {
            x = 0u;
            ++y;
        }
    } while (y < count.y);
}
