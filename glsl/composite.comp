#version 460
#extension GL_GOOGLE_include_directive : require
// Every tile's drops over one another, front to back, the sky behind; one invocation a tile, its
// pixels in registers. DISORDERED: of the tiles only that were found to need it, after their lists are
// put in order. CROWDED: of those that streaks make too long for one invocation, a workgroup a tile. FEW: of tiles with one
// entry or none. LONG: of those whose lists take several dispatches. See src/passes/composite.rs.
#ifdef CROWDED
#include "crowded_tile.glsl"
#else
#include "unfinished_tile.glsl"
#include "left_lanes.glsl"

layout(local_size_x = 64) in;

#ifdef FEW
void main() {
    uint number = group_number() * 64u + gl_LocalInvocationID.x;
    if (number >= totals.listed[LIST]) return;
    uint tile = drawn_tiles[listed_at(LIST, number)];
    uvec2 at = place_of_tile(tile);
    start_tile(at, tile);
    Row upper = NOTHING, lower = NOTHING;
    if (LIST == ONE_BLOCK) composite_block(upper, lower, head_of(tile));
    if (LIST == ONE_SPLAT) composite_splat(upper, lower, head_of(tile));
    finish_tile(tile, upper, lower);
}
#else
// Whether a splat comes next that this dispatch draws. Where no block is behind splats, all that is left is splats.
bool is_splat(Window w) {
    return w.taken < MOST_ENTRIES && w.nearest.link != END && !(MIXED && is_block(w.nearest.link));
}

// Lays a tile's entries over one another, front to back, up to MOST_ENTRIES. Returns the bits that all links have which were laid as
// splats: links of splats, and END, have the bit LINKS, those of blocks do not, so where it is missing a block came after splats.
uint composite_entries(inout Progress p, uint tile, uvec2 in_pixels) {
    // Blocks, then splats, and that once where it can be: a loop around the two costs a tenth of all. The splats' condition stands
    // last: first, llvmpipe would run the loop's body once more, with no lane in it, a ninth of the pass.
    uint turns = 0u, common_bits = END;
    do {
        while (p.window.taken < MOST_ENTRIES && is_block(p.window.nearest.link)) {
            if (has_streak_layer()) {
                uint to = max(p.window.nearest.distance2, p.streaks_from);
                composite_streak_layer(p.upper, p.lower, tile, in_pixels, p.streaks_from, to);
                p.streaks_from = to;
            }
            composite_block(p.upper, p.lower, p.window.nearest.link);
            take_nearest(p.window);
        }
        if (is_splat(p.window)) do {
            if (LOSES_LEFT != 0u && p.window.taken == END) break;
            common_bits &= p.window.nearest.link;
            composite_splat(p.upper, p.lower, p.window.nearest.link);
            take_nearest(p.window);
            if (!MIXED && FOR_GPU == 0u) {
                // Two a pass: CPU drivers write back all of a tile's pixels in each. On a GPU they would take more registers.
                common_bits &= p.window.nearest.link;
                composite_splat(p.upper, p.lower, p.window.nearest.link);
                take_nearest(p.window);
            }
        } while (is_splat(p.window));
    } while (MIXED && p.window.nearest.link != END && p.window.taken < MOST_ENTRIES && ++turns < MOST_TURNS);
    if (has_streak_layer() && p.window.nearest.link == END) {
        composite_streak_layer(p.upper, p.lower, tile, in_pixels, p.streaks_from, END);
    }
    return common_bits;
}

layout(constant_id = 33) const uint SORTED_BEFORE = 0; // 1: order_lists.comp puts the lists of disordered tiles in order

#ifdef DISORDERED
// Leaves a tile, whose list is in order now, to a workgroup of its own: here eight tiles share the bound on loops, there each
// has it for itself, and walks once.
void leave_to_crowd(uint number, uint tile, uint sorted) {
    heads[tile] = sorted;
    uint next = atomicAdd(totals.crowded, 1u);
    disordered_tiles[TILE_COUNT + next].x = number;
    atomicMax(totals.crowded_groups.x, min(next + 1u, ROW));
    atomicMax(totals.crowded_groups.y, next / ROW + 1u);
}

void main() {
    uint number = group_number() * 64u + gl_LocalInvocationID.x;
    if (number >= totals.disordered) return;
    uint tile = disordered_tiles[number].x, entries = disordered_tiles[number].y;
    uvec2 at = place_of_tile(tile);
    uint sorted = SORTED_BEFORE != 0u ? heads[tile] : order_tile(tile);
    Progress p = Progress(NOTHING, NOTHING, open_window(sorted), 0u);
    start_tile(at, tile);
    composite_entries(p, tile, at * TILE);
    if (has_streak_layer() && (streaks_are_cut || p.window.nearest.link != END)) {
        leave_to_crowd(number, tile, sorted);
        return;
    }
    // llvmpipe stops an invocation's loops after some 65,000 passes. Then what the first dispatch drew stays, nearly in order.
    if (p.window.taken < entries) {
        atomicAdd(counters.lost, entries - p.window.taken);
        return;
    }
    finish_tile(tile, p.upper, p.lower);
}
#elif defined(LONG)
layout(push_constant) uniform Push { uint walk, walks; } push; // which of these dispatches, from 0 on

void main() {
    uint number = group_number() * 64u + gl_LocalInvocationID.x, first = number * SAVED;
    if (number >= min(totals.unfinished, MOST_UNFINISHED) || kept(first).w != 0u) return;
    uvec4 head = kept(first);
    uint tile = head.x;
    uvec2 at = place_of_tile(tile);
    start_tile(at, tile);
    Progress p;
    if (push.walk == 0u) p = Progress(NOTHING, NOTHING, open_window(head_of(tile)), 0u);
    else p = saved(first, head.z != 0u);
    composite_entries(p, tile, at * TILE);
    bool is_done = p.window.nearest.link == END, is_last = push.walk + 1u == push.walks;
    uint taken = head.y + p.window.taken;
    keep(first, uvec4(tile, taken, uint(p.window.disordered), uint(is_done)));
    save(first, p);
    if (!is_done && is_last) lack_walks();
    // For an invocation alone it takes too long to sort so many.
    if (is_done && (p.window.disordered || streaks_are_cut)) atomicAdd(counters.lost, taken);
    if (is_done || is_last) finish_tile(tile, p.upper, p.lower);
}
#else
layout(push_constant) uniform Push { uint listed; } push; // 1: tiles with several entries; 0: all, region after region

// Where the place of a region is, in tiles. Lanes under each other share the columns of streaks.
uvec2 place_in_region(uint region, uint place) {
    uvec2 bits = region_tile_bits();
    uvec2 at = has_streak_layer() ? uvec2(place >> bits.y, place & (1u << bits.y) - 1u)
        : uvec2(place & (1u << bits.x) - 1u, place >> bits.x);
    return at + (divided(region, REGIONS_ACROSS).yx << bits);
}

// Lists a tile whose entries did not all come, or not in order (`common_bits`: see composite_entries).
void list_if_undone(uint tile, Window window, uint common_bits) {
    bool block_behind = (common_bits & LINKS) == 0u, is_left = window.nearest.link != END;
    // Where llvmpipe has ended the loops over streaks before that, a workgroup goes through all.
    bool is_long = is_left && (window.taken >= MOST_ENTRIES || !has_streak_layer());
    // A loop without turns is passed over, where both sides of a branch would be run.
    for (uint once = is_long ? 1u : 0u; once > 0u; --once) leave_unfinished(tile);
    if (!is_long && (window.disordered || block_behind || is_left || streaks_are_cut)) {
        uint next = atomicAdd(totals.disordered, 1u);
        disordered_tiles[next] = uvec2(tile, window.taken);
        atomicMax(totals.disordered_groups.x, next / 64u + 1u);
        if (SORTED_BEFORE != 0u) {
            atomicMax(totals.order_groups.x, min(next + 1u, ROW));
            atomicMax(totals.order_groups.y, next / ROW + 1u);
        }
    }
}

void main() {
    uint number = group_number() * 64u + gl_LocalInvocationID.x, tile;
    uvec2 at;
    if (push.listed != 0u) {
        if (number >= totals.listed[SEVERAL_ENTRIES]) return;
        tile = drawn_tiles[listed_at(SEVERAL_ENTRIES, number)];
        at = place_of_tile(tile);
    } else {
        uint region = number >> region_bits(), place = number & (1u << region_bits()) - 1u;
        at = place_in_region(region, place);
        tile = at.y * tiles_across() + at.x;
        // Where lists are short, it costs more than it saves.
        if (PREFETCH != 0u && BANDS > 1u) prefetch_nodes(region + 1u, place);
        if (at.x >= tiles_across() || tile >= TILE_COUNT) return;
    }
    Progress p = Progress(NOTHING, NOTHING, open_window(head_of(tile)), 0u);
    start_tile(at, tile);
    uint common_bits = composite_entries(p, tile, at * TILE);
    list_if_undone(tile, p.window, common_bits);
    finish_tile(tile, p.upper, p.lower);
}
#endif
#endif
#endif
