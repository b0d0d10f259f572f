#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// Where the clusters of each bin begin when they are sorted: sums of the counts before; one subgroup, each of
// whose invocations takes a run of bins. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "clusters.glsl"

layout(local_size_x = 128) in; // the largest subgroup there can be

void main() {
    if (gl_SubgroupID > 0u) return;
    uint runs = subgroupAdd(1u), run = subgroupExclusiveAdd(1u), bins = BANDS * REGIONS;
    uint length = (bins + runs - 1u) / runs, first = min(run * length, bins);
    uint last = min(first + length, bins), sum = 0u;
    for (uint bin = first; bin < last; ++bin) sum += totals.bin_counts[bin];
    uint start = subgroupExclusiveAdd(sum);
    for (uint bin = first; bin < last; ++bin) {
        totals.bin_starts[bin] = start;
        start += totals.bin_counts[bin];
    }
    if (subgroupElect()) {
        totals.bin_starts[bins] = totals.in_view;
        totals.sort_groups.x = max((totals.in_view + 63u) / 64u, 1u);
    }
}
