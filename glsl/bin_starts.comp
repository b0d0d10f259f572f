#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// Where the clusters of each bin begin when they are sorted: sums of the counts before; one subgroup, an
// invocation a bin. See src/passes/tiles.rs.
//
// Invocations beyond the last bin do all that the others do, as nothing promises that those come together again which a
// branch has parted (together.glsl).
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "population.glsl"

layout(local_size_x = MOST_TOGETHER) in;

void main() {
    if (gl_SubgroupID > 0u) return;
    uint together = subgroupAdd(1u), mine = subgroupExclusiveAdd(1u), bins = BANDS * REGIONS, sum = 0u;
    for (uint first = 0u; first <= bins; first += together) {
        uint bin = first + mine, count = totals.bin_counts[min(bin, bins - 1u)] * uint(bin < bins);
        count = clusters_of_bin(count);
        // The first beyond the last bin has the sum of all.
        totals.bin_starts[bin] = sum + subgroupExclusiveAdd(count);
        sum += subgroupAdd(count);
    }
    if (subgroupElect()) {
        uint found = note_in_view(sum);
        uint groups = max((found + 63u) / 64u, 1u);
        totals.sort_groups.xy = uvec2(min(groups, ROW), (groups + ROW - 1u) / ROW);
    }
}
