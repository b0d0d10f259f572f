#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// The drops of the clusters in view: where each is, whether it is in view; the small ones are entered
// into the lists of their tiles, the numbers of the others noted. One invocation a drop, a dispatch a
// band of depth, the farthest first. See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "octahedron.glsl"
#define VEIL_ACCESS
#include "tile_buffers.glsl"
#include "clusters.glsl"
#include "splat.glsl"
#include "tile_drop.glsl"
#include "lens.glsl"
#include "motion.glsl"
#include "shape.glsl"
#include "shape_given.glsl"
#include "drop_records.glsl"
#include "streak.glsl"
#include "disc.glsl"
#include "veil.glsl"
#include "veil_links.glsl"
#include "veil_discs.glsl"

layout(local_size_x = GATHER_GROUP) in;

#include "together.glsl"
#include "veil_parts.glsl"

layout(push_constant) uniform Push { uint band; } push;

void main() {
    uint group = group_number();
    uint place = totals.bin_starts[push.band * REGIONS]
        + group * CLUSTERS_A_GROUP + gl_LocalInvocationID.x / CLUSTER;
    if (place >= totals.bin_starts[(push.band + 1u) * REGIONS]) return;
    uint in_cluster = gl_LocalInvocationID.x % CLUSTER;
#ifdef CELLS
    if (place >= CLUSTERS) return;
    uint index = drop_order[place * CLUSTER + in_cluster];
#else
    uint index = drop_order[clusters_in_view[place] * CLUSTER + in_cluster];
#endif
    bool is_drop = index != NO_DROP;
    Drop drop = drop_of(is_drop ? index : 0u);
    float distance2;
    uint what = sighting(drop.view, drop.radius, reach_across(drop.view, drop.radius), distance2);
    bool exposed = is_exposed();
    Path path = path_at_rest();
    vec4 shape = shape_of(is_drop ? index : 0u, drop);
    if (exposed) {
        path = path_of(drop.view, drop.radius * reach_of_shape(shape), motion_of(is_drop ? index : 0u));
        if (path.moved != vec3(0.0)) what = sighting_moving(drop.view, path.moved, drop.radius);
    }
    bool known = is_drop && is_shown(index, drop, distance2);
    if (!known) what = OUT_OF_VIEW;

    Outline o = outline_of(drop, distance2);
    float deep = drop.radius;
    bool drawn = what == VISIBLE || what == BESIDE_CAMERA;
    if (!is_round(shape)) {
        // It is counted as the sphere of its volume is, and drawn where it is.
        deep = depth_of_shape(drop.radius, shape);
        if (!is_beside(drop.view, deep)) o = outline_of_shape(drop, seen_as(shape, path));
        bool inside = known && holds_camera(shape, -drop.relative / drop.radius);
        drawn = known && !inside && may_show(drop, path, shape, distance2);
        if (what == CAMERA_INSIDE && !inside) what = OUT_OF_VIEW;
    }
    vec2 half_sides = box_of_equal_area(o.box, o.radius);
    bool beside = drawn && (is_beside(drop.view, deep) || !path.even);
    bool streak = exposed && drawn && !beside && is_streak(drop, o, path, distance2);
    float opacity = 1.0;
    if (exposed) half_sides = blurred(half_sides, path, opacity);
    float blur = blur_of(drop.view, path.moved, drop.radius), disc = 0.0;
    if (is_lens() && blur > 0.0) {
        disc = disc_of(-drop.view.z);
        streak = streak || drawn && !beside && is_veil_disc(drop, o, path, disc, distance2);
        half_sides = defocused(half_sides, disc, opacity);
    }
    bool small = drawn && !beside && !streak && is_small(drop, o, half_sides, distance2) && is_short(o, path)
        && is_little(o.radius, disc);
    vec2 box = small ? half_sides : o.box;
    if (exposed) {
        o.center += path.aside;
        box += small ? vec2(0.0) : reach_of(path);
    }
    if (is_lens() && !small) box += blur;
    ivec4 pixels = pixels_in(o.center, box);
    bool shown = drawn && !beside && !streak && all(lessThanEqual(pixels.xy, pixels.zw));
    uvec2 first = uvec2(pixels.xy) / TILE, last = uvec2(pixels.zw) / TILE;
    // Of the drops in the whole picture those that the part shows.
    shown = shown && all(lessThan(first, end_tile())) && all(greaterThanEqual(last, first_tile()));
    bool splat = small && shown && all(lessThanEqual(last - first, uvec2(1u)));
    // A drop beside the camera has no outline: any pixel may see it.
    bool large = shown && !splat || beside;

    // One atomic a subgroup: a counter that every lane adds to is fought over.
    uvec4 visible_here = subgroupBallot(what == VISIBLE);
    uvec4 larges_here = subgroupBallot(large);
    uint large_count = subgroupBallotBitCount(larges_here), larges_before = subgroupBallotExclusiveBitCount(larges_here);
    uint at = 0u;
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.larges, large_count, leads, at);
    if (leads) {
        // Threads of a CPU, each of which draws one half, add to lines of their own.
        uint half_of_all = 2u * group >= gl_NumWorkGroups.x * gl_NumWorkGroups.y ? 32u : 0u;
        atomicAdd(counters.visible[(group & 31u) + half_of_all], subgroupBallotBitCount(visible_here));
        if (large_count > 0u) atomicMax(totals.large_groups.x, (min(at + large_count, MAX_LARGES) + 63u) / 64u);
    }
    at += larges_before;
    if (what == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
    uint number = place * CLUSTER + in_cluster;
    if ((splat || streak) && number >= MAX_SPLATS || large && at >= MAX_LARGES) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
        splat = streak = large = false;
    }
    if (large) larges[at].index = index;
    uint node = number * NODE;
    if (splat) {
        uint direction = direction_texel(drop.relative * inversesqrt(distance2));
        write_splat(node, distance2, index, o.center, half_sides, opacity, direction, first);
        hang_splat(node, first, last);
    }
    if (NEAREST != 0u && splat) drop_records[number] = record_of(index, drop);
    if (!is_spread()) return;

    Streak s = streak_of_drop(drop, o, path, disc, distance2);
    uint kind = kind_of_streak(s);
    uvec2 at_center;
    uvec4 rest;
    pack_streak(s, at_center, rest);
    if (is_lens() && is_disc(path, disc)) {
        Disc d = disc_of_drop(o, path, disc, opacity_at(distance2));
        pack_disc(d, at_center, rest);
        kind = kind_of_disc(d);
        s = around_disc(d);
    }
    VeilCells cells = cells_met(s, kind);
    uint wanted = streak ? cells.rows * cells.across : 0u, all_here = subgroupAdd(wanted), link = 0u;
    uint wanted_before = subgroupExclusiveAdd(wanted);
    leads = subgroupElect();
    TAKE_TOGETHER(totals.veil_links, all_here, leads, link);
    if (all_here == 0u) return;
    link += wanted_before;
    if (wanted > 0u && (link > VEIL_LINKS || link + wanted > VEIL_LINKS)) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
    } else if (wanted > 0u) {
        write_veil_node(node, distance2, at_center, rest);
        enter_streak(node, s, cells, link);
    }
    bool has_lines = wanted > 0u && LINE_PARTS != 0u && kind < DISCS && o.radius >= LINED_PX
        && o.radius * o.radius >= LINED_SHARE * length(path.way);
    enter_parts(node, s, has_lines);
}
