#ifndef CLUSTERS_GLSL
#define CLUSTERS_GLSL
// Clusters of drops, and those in view, which clusters.comp finds, bin_starts.comp and sort_clusters.comp put in
// order of their bins, and gather.comp draws. Needs tile_buffers.glsl.
const uint GATHER_GROUP = 256, CLUSTERS_A_GROUP = GATHER_GROUP / CLUSTER; // of gather.comp

#define CLUSTERS frame.clusters.x // all of them; CELLS: room for so many

#ifdef CELLS
#define MOST_CELLS frame.clusters.y // room for so many in view
// Numbers (cells.glsl) of the drops of the cells in view, bin after bin, of which each begins with a cluster.
layout(std430, set = 1, binding = 0) buffer DropOrder { uint drop_order[]; };
// Cells in view as they were found: number of the first drop, bin, its place in its bin, and drops.
layout(std430, set = 1, binding = 2) buffer InView { uvec4 cells_in_view[]; };
#else
#define RANDOM_CLUSTERS frame.clusters.y // the others' drops are placed by hand
// Indices of each cluster's drops. Never changes.
layout(std430, set = 1, binding = 0) readonly buffer DropOrder { uint drop_order[]; };
// `ClusterBox` in src/rain/clusters.rs of each cluster of random drops.
layout(std430, set = 1, binding = 1) readonly buffer ClusterBoxes { uvec4 cluster_boxes[]; };
// Numbers of the clusters in view, sorted; from CLUSTERS on, three words each as they were found: number, bin, and
// place in its bin.
layout(std430, set = 1, binding = 2) buffer InView { uint clusters_in_view[]; };

uint found_at(uint number) {
    return CLUSTERS + 3u * number;
}
#endif
#endif
