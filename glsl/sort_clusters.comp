#version 460
#extension GL_GOOGLE_include_directive : require
// The clusters in view to their places, bin after bin, one invocation a cluster (CELLS: the drops of the cells in view,
// one invocation a cell); and the workgroups of each band. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "clusters.glsl"

layout(local_size_x = 64) in;

const uint MOST_GROUPS = 65535; // of a dispatch along an axis, on any device

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number < BANDS) {
        uint in_band = totals.bin_starts[(number + 1u) * REGIONS] - totals.bin_starts[number * REGIONS];
        uint groups = (in_band + CLUSTERS_A_GROUP - 1u) / CLUSTERS_A_GROUP;
        uint rows = max((groups + MOST_GROUPS - 1u) / MOST_GROUPS, 1u);
        totals.gather_groups[number] = uvec4((groups + rows - 1u) / rows, rows, 1u, 0u);
    }
#ifdef CELLS
    const uint ROOM = CLUSTERS * CLUSTER;
    if (number < BANDS * REGIONS) {
        uint end = min(totals.bin_starts[number + 1u] * CLUSTER, ROOM);
        uint at = totals.bin_starts[number] * CLUSTER + totals.bin_counts[number];
        for (; at < end; ++at) drop_order[at] = NO_DROP;
    }
    if (number >= min(totals.cells_in_view, MOST_CELLS)) return;
    uvec4 cell = cells_in_view[number];
    uint at = totals.bin_starts[cell.y] * CLUSTER + cell.z, room = min(cell.w, ROOM - min(at, ROOM));
    for (uint i = 0u; i < room; ++i) drop_order[at + i] = cell.x + i;
    if (room < cell.w) {
        atomicAdd(counters.lost, cell.w - room);
        atomicOr(totals.lacks_room, 1u);
    }
#else
    if (number >= totals.in_view) return;
    uint at = found_at(number), bin = clusters_in_view[at + 1u];
    clusters_in_view[totals.bin_starts[bin] + clusters_in_view[at + 2u]] = clusters_in_view[at];
#endif
}
