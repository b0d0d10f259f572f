#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// Which cells of the rain are in view, which drops of each may be shown, and in which bin they are: band of depth, and region
// of the image. gather.comp decides which are shown; most of what it would leave out it does not get. One invocation a cell,
// then one a drop placed by hand. See src/passes/cells.rs.
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

// A bit for each of the first 32 drops of a cell that may be shown; none is left out that gather.comp would show. `more`: how
// many drops there are beside these 32.
uint drops_that_may_show(uint kind, ivec3 cell, float reach, out uint more) {
    uvec4 key = key_of(kind, cell);
    uint drops = drops_in(kind, key), firsts = min(drops, 32u), kept = 0u;
    vec3 half_way = 0.5 * abs(field.classes[kind].moved.xyz);
    for (uint number = 0u; number < firsts; ++number) {
        vec4 drop = drop_of_key(kind, cell, key, number);
        vec3 v = view_space(drop.xyz);
        precise float distance2 = (v.x * v.x + v.y * v.y) + v.z * v.z;
        bool may_show = shown_alone(kind, number, v, drop.w, distance2)
            && meets_view(drop.xyz, half_way, reach_from_box(drop.xyz, half_way, reach));
        kept |= uint(may_show) << number;
    }
    more = drops - firsts;
    return kept;
}

void main() {
    uint group = group_number(), candidate = group * CELLS_GROUP + gl_LocalInvocationID.x;
    uint kept = 0u, more = 0u, bin = 0u, first = candidate * 64u;
    if (group < field.groups.x) {
        Slab slab = slab_of_group(group);
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
            kept = drops_that_may_show(slab.kind, cell, reach, more);
            float depth = -dot(frame.back.xyz, center);
            bin = band_at(depth) * REGIONS + region_at(center, depth, limits.x);
        }
    } else {
        uint number = candidate - field.groups.x * CELLS_GROUP;
        kept = number < field.groups.y ? 1u : 0u;
        // They can be anywhere.
        bin = (BANDS - 1u) * REGIONS + number % MAX_REGIONS * REGIONS / MAX_REGIONS;
        first = IS_PLACED | number;
    }
    uint drops = bitCount(kept) + more;
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
    cells_in_view[number] = uvec4(first, bin | more << 16, atomicAdd(totals.bin_counts[bin], drops), kept);
}
