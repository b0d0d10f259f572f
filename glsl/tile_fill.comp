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
layout(constant_id = 4) const float RAYS_PX = 8.0;
layout(constant_id = 5) const uint MAY_RAY = 0; // 1: so small a drop may be drawn by rays

#define COUNTERS_BINDING 15
#include "counters.glsl"
#include "tile_entry.glsl"

void main() {
    uint record = gl_GlobalInvocationID.x;
    if (record >= min(totals.records, MAX_RECORDS)) return;
    uvec2 bin = bins[record];
    uvec2 count = uvec2(bin.y & 0xffffu, bin.y >> 16);
    if (bin.y == 0u || count.x * count.y > MOST_TILES) return;
    float distance2 = records[record].distance2;
    bool rays = MAY_RAY != 0u && radius_of(records[record].to_disc) > RAYS_PX;
    uint tile = (bin.x >> 16) * tiles_across() + (bin.x & 0xffffu);
    uint slab = slab_of(distance2, SLABS), x = 0u, y = 0u;
    do {
        uint at = tile + y * tiles_across() + x;
        enter(at * SLABS + slab, at, record, distance2, rays);
        if (++x == count.x) {
            x = 0u;
            ++y;
        }
    } while (y < count.y);
}
