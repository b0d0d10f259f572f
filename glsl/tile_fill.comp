#version 460
#extension GL_GOOGLE_include_directive : require
// Writes every drop into the lists of its tiles; one invocation a record.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint MAX_ENTRIES = 1;
layout(constant_id = 1) const uint MAX_RECORDS = 1;

#define COUNTERS_BINDING 16
#include "counters.glsl"

void main() {
    uint record = gl_GlobalInvocationID.x;
    if (record >= min(totals.records, MAX_RECORDS)) return;
    uvec4 bin = bins[record];
    uvec2 first = uvec2(bin.x & 0xffffu, bin.x >> 16);
    uvec2 count = uvec2(bin.y & 0xffu, bin.y >> 8 & 0xffu);
    bool wide = bin.y >> 31 != 0u;
    uint tiles_across = (uint(frame.image.x) + TILE - 1u) / TILE;
    float distance2 = bin.y != 0u ? records[record].distance2 : 0.0;
    float far = distance2 * frame.tone.z;
    uint slab = uint(min(far * sqrt(far) * float(SLABS), float(SLABS) - 1.0));
    uint number = 0u;
    for (uint y = 0u; y < count.y; ++y) {
        for (uint x = 0u; x < count.x; ++x, ++number) {
            uint at = ((first.y + y) * tiles_across + first.x + x) * SLABS + slab;
            uint entry;
            if (wide) {
                entry = atomicAdd(slab_wide[at], 1u);
            } else {
                uint places = number < 2u ? bin.z : bin.w;
                uint place = places >> (16u * (number & 1u)) & 0xffffu;
                entry = slab_small[at] + place;
                if (place == 0xffffu) entry = MAX_ENTRIES; // the slab's list is full
            }
            if (entry < MAX_ENTRIES) entries[entry] = uvec2(floatBitsToUint(distance2), record);
            else atomicAdd(counters.lost, 1u);
        }
    }
}
