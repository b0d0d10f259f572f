// Clusters of drops, and those in view: what clusters.comp hands to gather.comp. Needs tile_buffers.glsl.
const uint CLUSTER = 16, NO_DROP = 0xffffffffu; // as in src/clusters.rs
const uint GATHER_GROUP = 256, CLUSTERS_A_GROUP = GATHER_GROUP / CLUSTER; // of gather.comp
const uint STRETCHES = 64; // of all clusters, of which the workgroups of clusters.comp take parts in turn

layout(constant_id = 13) const uint CLUSTERS = 1;        // all of them
layout(constant_id = 14) const uint RANDOM_CLUSTERS = 1; // the others' drops are placed by hand
layout(constant_id = 15) const uint BANDS = 1;
layout(constant_id = 16) const uint BAND_ROOM = 1;   // numbers of clusters provided for each band,
layout(constant_id = 17) const uint MAX_IN_VIEW = 1; // and taken at most for either half of the image

// Indices of each cluster's drops. Never changes.
layout(std430, set = 0, binding = 1) readonly buffer DropOrder { uint drop_order[]; };
// `ClusterBox` in src/clusters.rs of each cluster of random drops.
layout(std430, set = 0, binding = 2) readonly buffer ClusterBoxes { uvec4 cluster_boxes[]; };
// Numbers of the clusters in view, band by band: those above the image's middle from the band's first place
// on, the others from its last. So the two halves of a dispatch over them, which CPU drivers give to
// different threads, do not fight for the same lists.
layout(std430, set = 0, binding = 12) buffer ClustersInView { uint clusters_in_view[]; };

uint in_view_at(uint band, bool below, uint place) {
    return band * BAND_ROOM + (below ? BAND_ROOM - 1u - place : place);
}
