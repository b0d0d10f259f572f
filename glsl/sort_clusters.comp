#version 460
#extension GL_GOOGLE_include_directive : require
// The clusters in view to their places, bin after bin, one invocation a cluster (of real rain the drops of the cells in view,
// one invocation a cell); and the workgroups of each band. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "population.glsl"

layout(local_size_x = 64) in;

const uint MOST_GROUPS = 65535; // of a dispatch along an axis, on any device

void main() {
    uint number = group_number() * 64u + gl_LocalInvocationID.x;
    if (number < BANDS) {
        uint in_band = totals.bin_starts[(number + 1u) * REGIONS] - totals.bin_starts[number * REGIONS];
        uint groups = (in_band + CLUSTERS_A_GROUP - 1u) / CLUSTERS_A_GROUP;
        uint rows = max((groups + MOST_GROUPS - 1u) / MOST_GROUPS, 1u);
        totals.gather_groups[number] = uvec4((groups + rows - 1u) / rows, rows, 1u, 0u);
    }
    sort_found(number);
}
