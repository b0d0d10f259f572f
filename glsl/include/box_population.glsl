#ifndef BOX_POPULATION_GLSL
#define BOX_POPULATION_GLSL
// Drops in boxes, in clusters, of which clusters.comp finds those in view: population.glsl has its functions.
#include "by_hand.glsl"
#include "drop.glsl"
#include "tile_buffers.glsl"

#define CLUSTERS frame.clusters.x
#define RANDOM_CLUSTERS frame.clusters.y // the others' drops are placed by hand
// Indices of each cluster's drops. Never changes.
layout(std430, set = 1, binding = 0) readonly buffer DropOrder { uint drop_order[]; };
layout(set = 1, binding = 10) uniform usamplerBuffer order_words;
// `ClusterBox` in src/rain/clusters.rs of each cluster of random drops.
layout(std430, set = 1, binding = 1) readonly buffer ClusterBoxes { uvec4 cluster_boxes[]; };
layout(set = 1, binding = 17) uniform usamplerBuffer box_texels;
// Numbers of the clusters in view, sorted; from CLUSTERS on, three words each as they were found: number, bin, and
// place in its bin.
layout(std430, set = 1, binding = 2) buffer InView { uint clusters_in_view[]; };
layout(set = 1, binding = 15) uniform usamplerBuffer in_view_words;

uint drop_in_order(uint place) {
    return BY_TEXELS != 0u ? texelFetch(order_words, int(place)).x : drop_order[place];
}

uvec4 box_of(uint cluster) {
    return BY_TEXELS != 0u ? texelFetch(box_texels, int(cluster)) : cluster_boxes[cluster];
}

uint found_at(uint number) {
    return CLUSTERS + 3u * number;
}

// Clusters that what was counted of a bin fills.
uint clusters_of_bin(uint count) {
    return count;
}

// Notes that so many clusters are in view; returns how many invocations sort them.
uint note_in_view(uint clusters) {
    return totals.in_view;
}

// Puts what was found under a number into its place.
void sort_found(uint number) {
    if (number >= totals.in_view) return;
    uint at = found_at(number), bin = clusters_in_view[at + 1u];
    clusters_in_view[start_of_bin(bin) + clusters_in_view[at + 2u]] = clusters_in_view[at];
}

// Whether there is a sorted cluster at a place.
bool is_cluster(uint place) {
    return true;
}

// Index of a drop of it.
uint index_at(uint place, uint in_cluster) {
    uint cluster = BY_TEXELS != 0u ? texelFetch(in_view_words, int(place)).x : clusters_in_view[place];
    return drop_in_order(cluster * CLUSTER + in_cluster);
}

Drop random_drop(uint index) {
    vec4 at = drop_at(population_numbered(population_number(index)), index);
    return Drop(at.xyz, vec3(0.0), at.w);
}

// Is a drop shown by itself, or part of a medium?
bool is_shown(uint index, Drop drop, float distance2) {
    return true;
}

float stands_for(uint index, Drop drop) {
    return 1.0;
}

// How far a random drop moves while the shutter is open, world axes.
vec3 random_motion(uint index) {
    return population_numbered(population_number(index)).moved.xyz;
}

// Number of the entry of `motion` (drop_records.glsl) that a random drop has.
uint kind_of(uint index) {
    return population_number(index);
}

// A random drop's number in layers, low and high word.
uvec2 random_number(uint index) {
    return uvec2(index + 1u, 0u);
}

// Diameter in mm by which a random drop is flattened, of a unit of radius; 0: it is a sphere.
float flattened_mm(Drop drop, float mm) {
    return 0.0;
}

// The number by which drops are told apart where something is left to chance.
uint number_for_chance(uint index, Drop drop) {
    return index;
}
#endif
