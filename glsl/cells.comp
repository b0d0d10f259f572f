#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// Which cells of the rain are in view, how many drops each holds, and in which bin they are: band of depth, and region
// of the image. One invocation a cell, then one a drop placed by hand. See src/passes/cells.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "projection.glsl"
#include "tile_buffers.glsl"
#include "cell_population.glsl"
#include "view_volume.glsl"
#include "lens.glsl"
#include "together.glsl"

layout(local_size_x = CELLS_GROUP) in;

uint band_at(float depth) {
    uint nearer = 0u;
    for (uint i = 0u; i < BANDS; ++i) {
        uint last = (i + 1u) * MAX_BANDS / BANDS - 1u;
        nearer += depth > field.band_depths[last / 4u][last % 4u] ? 1u : 0u;
    }
    return BANDS - 1u - min(nearer, BANDS - 1u);
}

void main() {
    uint group = group_number(), candidate = group * CELLS_GROUP + gl_LocalInvocationID.x;
    uint drops = 0u, bin = 0u, first = candidate * 64u;
    if (group < field.groups.x) {
        Slab slab = field.slabs[field.group_slabs[group]];
        uint number = candidate - slab.first_group * CELLS_GROUP;
        ivec3 cell = cell_of(slab, number);
        float edge = field.classes[slab.kind].moved.w;
        vec3 moved = field.classes[slab.kind].moved.xyz;
        vec3 corner = (vec3(cell) - vec3(field.classes[slab.kind].fraction.xyz) * (1.0 / 4294967296.0)) * edge;
        vec3 center = corner + 0.5 * edge, half_size = 0.5 * (edge + abs(moved));
        vec2 limits = field.classes[slab.kind].limits.xy;
        // Rounding must not lose a drop that `visibility` would show.
        float reach = limits.x * 1.001 + 1e-5 * limits.y;
        float nearest = -dot(frame.back.xyz, center) - dot(abs(frame.back.xyz), half_size);
        if (number < slab.cells && nearest <= limits.y + reach && meets_view(center, half_size, reach_from_box(center, half_size, reach))) {
            drops = drops_in(slab.kind, key_of(slab.kind, cell));
            float depth = -dot(frame.back.xyz, center);
            bin = band_at(depth) * REGIONS + region_at(center, depth, limits.x);
        }
    } else {
        uint number = candidate - field.groups.x * CELLS_GROUP;
        drops = number < field.groups.y ? 1u : 0u;
        // They can be anywhere.
        bin = (BANDS - 1u) * REGIONS + number % MAX_REGIONS * REGIONS / MAX_REGIONS;
        first = IS_PLACED | number;
    }
    uvec4 found = subgroupBallot(drops > 0u);
    uint number = 0u, count = subgroupBallotBitCount(found), before = subgroupBallotExclusiveBitCount(found);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.cells_in_view, count, leads, number);
    if (drops == 0u) return;
    number += before;
    if (number >= MOST_CELLS) {
        atomicAdd(counters.lost, drops);
        atomicOr(totals.lacks_room, 1u);
        return;
    }
    cells_in_view[number] = uvec4(first, bin, atomicAdd(totals.bin_counts[bin], drops), drops);
}
