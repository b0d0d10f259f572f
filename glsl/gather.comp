#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// The drops of the cells in view: where each is, whether it is in view; the small ones are entered
// into the lists of their tiles, the numbers of the others noted. One invocation a record, a dispatch a
// band of distance, the farthest first. See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "octahedron.glsl"
#include "tile_buffers.glsl"
#include "tile_drop.glsl"
#include "splat.glsl"
#include "appearance.glsl"

layout(local_size_x = 256) in;

#define COUNTERS_BINDING 13
#include "counters.glsl"

layout(push_constant) uniform Push { uint band; } push;

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (push.band > 0u) at += totals.record_ends[push.band - 1u];
    if (at >= totals.record_ends[push.band]) return;
    uint index = record_index[at];
    Drop drop = drop_of(index);
    float distance2;
    uint what = sighting(drop.view, drop.radius, distance2);

    Outline o = outline_of(drop, distance2);
    vec2 half_sides = box_of_equal_area(o.box, o.radius);
    bool near_by = distance2 < NEAR_RADII * NEAR_RADII * drop.radius * drop.radius;
    bool small = what == VISIBLE && o.radius < SPLAT_PX && !near_by && opacity_at(distance2) == 1.0;
    ivec4 pixels = pixels_in(o.center, small ? half_sides : o.box);
    bool shown = what == VISIBLE && all(lessThanEqual(pixels.xy, pixels.zw));
    uvec2 first = uvec2(pixels.xy) / TILE, last = uvec2(pixels.zw) / TILE;
    bool splat = small && shown && all(lessThanEqual(last - first, uvec2(1u)));
    // A drop beside the camera has no outline: any pixel may see it.
    bool large = shown && !splat || what == BESIDE_CAMERA;

    if (splat) {
        uint node = at * NODE;
        nodes[node] = floatBitsToUint(distance2);
        uint direction = direction_texel(drop.relative * inversesqrt(distance2));
        nodes[node + 1u] = pictures[picture_word(direction, 1u)];
        nodes[node + 2u] = pack_center(o.center - vec2(first * TILE));
        nodes[node + 3u] = pack_half_sides(half_sides);
    }
    uint tile = first.y * tiles_across() + first.x;
    for (uint i = 0u; i < 4u; ++i) {
        uvec2 step = uvec2(i & 1u, i >> 1);
        if (splat && all(lessThanEqual(first + step, last))) {
            uint link = at * NODE + LINKS + i;
            nodes[link] = atomicExchange(heads[tile + step.y * tiles_across() + step.x], link);
        }
    }

    // One atomic a subgroup: a counter that every lane adds to is fought over.
    uvec4 visible = subgroupBallot(what == VISIBLE), larges_here = subgroupBallot(large);
    uint place = 0u;
    if (subgroupElect()) {
        atomicAdd(counters.visible[gl_WorkGroupID.x & 63u], subgroupBallotBitCount(visible));
        place = atomicAdd(totals.larges, subgroupBallotBitCount(larges_here));
    }
    place = subgroupBroadcastFirst(place) + subgroupBallotExclusiveBitCount(larges_here);
    if (what == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
    if (large && place < MAX_LARGES) {
        larges[place].index = index;
        atomicMax(totals.large_groups.x, place / 64u + 1u);
    }
    if (large && place >= MAX_LARGES) atomicAdd(counters.lost, 1u);
}
