#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// Takes the drops of the clusters in view, finds where each is and what it is drawn as, and hands it on: a small drop is entered
// into the lists of its tiles, a streak or disc of one colour into the lists of its cells, a large drop is noted for large.comp.
// One invocation a drop; a dispatch a band of depth, the farthest first, so that lists are nearly in order. See
// src/passes/tiles.rs. SHELTER: drops below a surface are left out.
#ifdef CELLS_SHELTER
#define SHELTER
#endif
#include "frame.glsl"
#include "rain.glsl"
#define STREAK_LAYER_ACCESS
#include "tile_buffers.glsl"
#include "shown_from.glsl"
#include "splat.glsl"
#include "tile_drop.glsl"
#include "lens.glsl"
#include "motion.glsl"
#include "shape.glsl"
#include "shape_given.glsl"
#include "drop_records.glsl"
#include "streak.glsl"
#include "disc.glsl"
#include "streak_layer.glsl"
#include "streak_layer_links.glsl"
#include "streak_layer_discs.glsl"
#ifdef SHELTER
#include "shelter.glsl"
#endif

layout(local_size_x = GATHER_GROUP) in;

#include "together.glsl"
#include "streak_layer_parts.glsl"

layout(push_constant) uniform Push { uint first_bin, end_bin; } push; // of a band

const float LEAST_WAY = 0.1; // pixels of a streak, which needs a direction

// Where a drop is, how it moves, and where the sphere of its volume is seen.
struct Located {
    uint index;
    Drop drop;
    float distance2; // from the camera to its centre, squared
    vec4 shape;      // see shape.glsl
    Path path;       // how it moves while the shutter is open
    float wider;     // as it is drawn, over as it is: over 1, it stands for others
    bool is_known;   // it is drawn by itself: it is a drop (the last cluster has gaps), not part of the medium, not sheltered
    uint visibility; // of that sphere, at any time of the exposure; OUT_OF_VIEW unless `is_known`
};

Located locate(uint index) {
    Located l;
    bool is_drop = index != NO_DROP;
    l.index = is_drop ? index : 0u;
    l.drop = drop_of(l.index);
    l.visibility = visibility(l.drop.view, l.drop.radius, reach_across(l.drop.view, l.drop.radius), l.distance2);
    l.path = path_at_rest();
    l.shape = shape_of(l.index, l.drop);
    l.wider = stands_for(l.index, l.drop);
    if (is_exposed()) {
        l.path = path_of(l.drop.view, l.drop.radius * reach_of_shape(l.shape), motion_of(l.index));
        if (l.path.moved != vec3(0.0)) l.visibility = visibility_moving(l.drop.view, l.path.moved, l.drop.radius);
    }
    l.is_known = is_drop && is_shown(index, l.drop, l.distance2);
#ifdef SHELTER
    if (l.is_known && !is_by_hand(index)) l.is_known = !is_sheltered(l.drop.relative, shelter.lines[kind_of(index)]);
#endif
    if (!l.is_known) l.visibility = OUT_OF_VIEW;
    return l;
}

// Whether anything of a drop is drawn; its outline; and whether it is `beside`: at the camera's plane, or so much nearer at one
// end of the exposure that no outline tells where it is. A drop that is no sphere is counted where the sphere of its volume is,
// but drawn where it is itself.
bool is_drawn(inout Located l, out Outline o, out bool beside) {
    o = outline_of(l.drop, l.distance2);
    float deep = l.drop.radius; // how far it reaches along the view axis
    bool drawn = l.visibility == VISIBLE || l.visibility == BESIDE_CAMERA;
    if (!is_round(l.shape)) {
        deep = depth_of_shape(l.drop.radius, l.shape);
        if (!is_beside(l.drop.view, deep)) o = outline_of_shape(l.drop, seen_as(l.shape, l.path));
        bool inside = l.is_known && holds_camera(l.shape, -l.drop.relative / l.drop.radius);
        drawn = l.is_known && !inside && may_show(l.drop, l.path, l.shape, l.distance2);
        if (l.visibility == CAMERA_INSIDE && !inside) l.visibility = OUT_OF_VIEW;
    }
    o.box *= l.wider;
    o.radius *= l.wider;
    beside = drawn && (is_beside(l.drop.view, deep) || !l.path.even);
    return drawn;
}

// What a drop is drawn as: at most one of the three. A splat is a box of two colours on at most 2 x 2 tiles; a streak, or a disc
// of a drop out of focus, has one colour; all else is large.
struct Form {
    bool splat, streak, large;
    vec2 half_sides; // of the splat's box, in pixels; wider where motion or lens spread the drop
    float opacity;   // of the splat: under 1 where its box is wider than the drop
    float disc;      // radius in pixels of the disc that the lens makes of a point of the drop; 0: in focus
    uvec2 first, last; // tiles that the drop touches
};

// The form of a drop. Moves the outline's centre to the middle of the drop's way.
Form form_of(Located l, inout Outline o, bool drawn, bool beside) {
    Form f;
    bool exposed = is_exposed();
    f.half_sides = box_of_equal_area(o.box, o.radius);
    // A splat would be noted as a pixel's nearest drop, which a drop that stands for others is not.
    bool as_streak = l.wider > 1.0 && SPLAT_PX > 0.0 && length(l.path.way) > LEAST_WAY;
    f.streak = exposed && drawn && !beside && (as_streak || is_streak(l.drop, o, l.path, l.distance2));
    f.opacity = 1.0;
    if (exposed) f.half_sides = blurred(f.half_sides, l.path, f.opacity);
    float blur = blur_of(l.drop.view, l.path.moved, l.drop.radius);
    f.disc = 0.0;
    if (is_lens() && blur > 0.0) {
        f.disc = disc_of(-l.drop.view.z);
        f.streak = f.streak || drawn && !beside && is_one_colour_disc(l.drop, o, l.path, f.disc, l.distance2);
        f.half_sides = defocused(f.half_sides, f.disc, f.opacity);
    }
    bool small = drawn && !beside && !f.streak && is_small(l.drop, o, f.half_sides, l.distance2) && is_short(o, l.path)
        && is_little(o.radius, f.disc);
    vec2 box = small ? f.half_sides : o.box;
    if (exposed) {
        o.center += l.path.aside;
        box += small ? vec2(0.0) : reach_of(l.path);
    }
    if (is_lens() && !small) box += blur;
    ivec4 pixels = pixels_in(o.center, box);
    bool shown = drawn && !beside && !f.streak && all(lessThanEqual(pixels.xy, pixels.zw));
    f.first = uvec2(pixels.xy) / TILE;
    f.last = uvec2(pixels.zw) / TILE;
    // Only the part of the picture that is drawn counts.
    shown = shown && all(lessThan(f.first, end_tile())) && all(greaterThanEqual(f.last, first_tile()));
    f.splat = small && shown && all(lessThanEqual(f.last - f.first, uvec2(1u)));
    // A drop beside the camera has no outline: any pixel may see it.
    f.large = shown && !f.splat || beside;
    return f;
}

// Counts the subgroup's visible drops, and numbers its large ones; returns this invocation's number. One atomic a subgroup,
// because lanes wait for each other at a counter that all add to.
uint number_large(uint group, bool visible, bool large) {
    uvec4 visible_here = subgroupBallot(visible), larges_here = subgroupBallot(large);
    uint count = subgroupBallotBitCount(larges_here), before = subgroupBallotExclusiveBitCount(larges_here), at = 0u;
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.larges, count, leads, at);
    if (leads) {
        // Two threads of a CPU take about half of the workgroups each. Both halves add to slots in cache lines of their own.
        uint half_of_all = 2u * group >= gl_NumWorkGroups.x * gl_NumWorkGroups.y ? 32u : 0u;
        atomicAdd(counters.visible[(group & 31u) + half_of_all], subgroupBallotBitCount(visible_here));
        if (count > 0u) atomicMax(totals.large_groups.x, (min(at + count, MAX_LARGES) + 63u) / 64u);
    }
    return at + before;
}

// Enters the subgroup's streaks and discs into the lists of their cells (streak_layer.glsl). All invocations come here, also
// those without a streak, because the subgroup takes its links together.
void enter_streaks(uint node, Located l, Outline o, Form f) {
    Streak s = streak_of_drop(l.drop, o, l.path, f.disc, l.distance2);
    uint kind = kind_of_streak(s);
    uvec2 at_center;
    uvec4 rest;
    pack_streak(s, at_center, rest);
    if (is_lens() && is_disc(l.path, f.disc)) {
        Disc d = disc_of_drop(o, l.path, f.disc, opacity_at(l.distance2));
        pack_disc(d, at_center, rest);
        kind = kind_of_disc(d);
        s = around_disc(d);
    }
    StreakCells cells = cells_met(s, kind);
    uint wanted = f.streak ? cells.rows * cells.across : 0u, all_here = subgroupAdd(wanted), link = 0u;
    uint wanted_before = subgroupExclusiveAdd(wanted);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.streak_links, all_here, leads, link);
    STAY_BEYOND(totals.streak_links, STREAK_LINKS, leads, link);
    if (all_here == 0u) return;
    link += wanted_before;
    if (wanted > 0u && (link > STREAK_LINKS || link + wanted > STREAK_LINKS)) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
    } else if (wanted > 0u) {
        write_streak_node(node, l.distance2, at_center, rest);
        enter_streak(node, s, cells, link);
    }
    bool has_lines = wanted > 0u && LINE_PARTS != 0u && kind < DISCS && o.radius >= LINED_PX
        && o.radius * o.radius >= LINED_SHARE * length(l.path.way);
    enter_parts(node, s, has_lines);
}

void main() {
    uint group = group_number();
    // Both are found by a push constant, before any branch: there CPU drivers read once what is the same for all lanes.
    uint end = totals.bin_starts[push.end_bin];
    uint place = totals.bin_starts[push.first_bin] + group * CLUSTERS_A_GROUP + gl_LocalInvocationID.x / CLUSTER;
    if (place >= end) return;
    uint in_cluster = gl_LocalInvocationID.x % CLUSTER;
    if (!is_cluster(place)) return;
    uint index = index_at(place, in_cluster);
    Located l = locate(index);
    Outline o;
    bool beside, drawn = is_drawn(l, o, beside);
    Form f = form_of(l, o, drawn, beside);

    uint at = number_large(group, l.visibility == VISIBLE, f.large);
    if (l.visibility == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
    uint number = place * CLUSTER + in_cluster, node = number * NODE;
    if ((f.splat || f.streak) && number >= MAX_SPLATS || f.large && at >= MAX_LARGES) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
        f.splat = f.streak = f.large = false;
    }
    if (f.large) larges[at].index = index;
    if (f.splat) {
        uint direction = shown_from(l.drop.relative * inversesqrt(l.distance2), l.drop.view);
        write_splat(node, l.distance2, index, o.center, f.half_sides, f.opacity, direction, f.first);
        push_splat(node, f.first, f.last);
    }
    if (NEAREST != 0u && f.splat) drop_records[number] = record_of(index, l.drop);
    if (is_spread()) enter_streaks(node, l, o, f);
}
