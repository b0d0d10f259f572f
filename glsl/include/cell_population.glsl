#ifndef CELL_POPULATION_GLSL
#define CELL_POPULATION_GLSL
// Drops of real rain, in cells, of which cells.comp finds those in view: population.glsl has its functions.
#include "cells.glsl"
#include "by_hand.glsl"
#include "drop.glsl"
#include "tile_buffers.glsl"

#define CLUSTERS frame.clusters.x   // room for so many
#define MOST_CELLS frame.clusters.y // room for so many in view
// Numbers (cells.glsl) of the drops of the cells in view, bin after bin, of which each begins with a cluster.
layout(std430, set = 1, binding = 0) buffer DropOrder { uint drop_order[]; };
layout(set = 1, binding = 10) uniform usamplerBuffer order_words;
// Cells in view as they were found: number of the first drop; bin, and in the upper half how many drops after the first 32 there
// are; its place in its bin; a bit for each of the first 32 drops that may be shown.
layout(std430, set = 1, binding = 2) buffer InView { uvec4 cells_in_view[]; };

// Drops were counted, and fill up clusters.
uint clusters_of_bin(uint count) {
    return (count + CLUSTER - 1u) / CLUSTER;
}

// One invocation a cell, and one a bin, which may be more.
uint note_in_view(uint clusters) {
    totals.in_view = min(clusters, CLUSTERS);
    return max(min(totals.cells_in_view, MOST_CELLS), BANDS * REGIONS);
}

void sort_found(uint number) {
    const uint ROOM = CLUSTERS * CLUSTER;
    if (number < BANDS * REGIONS) {
        uint end = min(start_of_bin(number + 1u) * CLUSTER, ROOM);
        uint at = start_of_bin(number) * CLUSTER + totals.bin_counts[number];
        for (; at < end; ++at) drop_order[at] = NO_DROP;
    }
    if (number >= min(totals.cells_in_view, MOST_CELLS)) return;
    uvec4 cell = cells_in_view[number];
    uint at = start_of_bin(cell.y & 0xffffu) * CLUSTER + cell.z, firsts = bitCount(cell.w), left = cell.w;
    uint drops = firsts + (cell.y >> 16), room = min(drops, ROOM - min(at, ROOM));
    for (uint i = 0u; i < room; ++i) {
        drop_order[at + i] = cell.x + (i < firsts ? uint(findLSB(left)) : 32u + i - firsts);
        left &= left - 1u;
    }
    if (room < drops) {
        atomicAdd(counters.lost, drops - room);
        atomicOr(totals.lacks_room, 1u);
    }
}

bool is_cluster(uint place) {
    return place < CLUSTERS;
}

uint index_at(uint place, uint in_cluster) {
    uint at = place * CLUSTER + in_cluster;
    return BY_TEXELS != 0u ? texelFetch(order_words, int(at)).x : drop_order[at];
}

Slab slab_of(uint index) {
    return slab_of_group(min(index / (64u * CELLS_GROUP), field.groups.x - 1u));
}

Drop random_drop(uint index) {
    Slab slab = slab_of(index);
    ivec3 cell = cell_of(slab, index / 64u - slab.first_group * CELLS_GROUP);
    vec4 at = drop_in_cell(slab.kind, cell, index % 64u);
    return Drop(at.xyz, vec3(0.0), at.w);
}

bool is_shown(uint index, Drop drop, float distance2) {
    return is_by_hand(index) || shown_alone(slab_of(index).kind, index % 64u, drop.view, drop.radius, distance2);
}

// How many times as wide a drop is drawn as it is, because it stands for others.
float stands_for(uint index, Drop drop) {
    return is_by_hand(index) ? 1.0 : max(field.shown.x * -drop.view.z / (drop.radius * frame.image.z), 1.0);
}

vec3 random_motion(uint index) {
    return field.classes[slab_of(index).kind].moved.xyz;
}

uint kind_of(uint index) {
    return slab_of(index).kind;
}

// `drop_number` in src/rain/field.rs: seventeen bits of the cell's number along each axis.
uvec2 random_number(uint index) {
    Slab slab = slab_of(index);
    ivec3 from_camera = cell_of(slab, index / 64u - slab.first_group * CELLS_GROUP);
    uvec3 cell = (field.classes[slab.kind].cell_low.xyz + uvec3(from_camera)) & 0x1ffffu;
    return uvec2(index % 64u + 1u | cell.x << 7 | cell.y << 24, cell.y >> 8 | cell.z << 9 | slab.kind + 1u << 26);
}

float flattened_mm(Drop drop, float mm) {
    return mm * drop.radius;
}

// A cell's place among those in view is another in each part of a picture, a drop's radius and its number in the cell are not.
uint number_for_chance(uint index, Drop drop) {
    return is_by_hand(index) ? index : floatBitsToUint(drop.radius) * 64u + index % 64u;
}
#endif
