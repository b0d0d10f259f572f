#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// Where the clusters of each bin begin when they are sorted: sums of the counts before; one subgroup, an
// invocation a bin. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "clusters.glsl"

layout(local_size_x = 128) in; // the largest subgroup there can be

void main() {
    if (gl_SubgroupID > 0u) return;
    uint together = subgroupAdd(1u), mine = subgroupExclusiveAdd(1u), bins = BANDS * REGIONS, sum = 0u;
    for (uint first = 0u; first < bins; first += together) {
        uint bin = first + mine, count = bin < bins ? totals.bin_counts[bin] : 0u;
        uint start = sum + subgroupExclusiveAdd(count);
        if (bin < bins) totals.bin_starts[bin] = start;
        sum += subgroupAdd(count);
    }
    if (subgroupElect()) {
        totals.bin_starts[bins] = totals.in_view;
        totals.sort_groups.x = max((totals.in_view + 63u) / 64u, 1u);
    }
}
