#version 460
#extension GL_GOOGLE_include_directive : require
// Every tile's drops over one another, front to back, the sky behind; one invocation a tile, its
// pixels in registers. DISORDERED: of the tiles only that were found to need it, after their lists are
// put in order. CROWDED: of those that streaks make too long for one invocation, a workgroup a tile. FEW: of tiles with one
// entry or none. See src/passes/composite.rs.
#ifdef CROWDED
#include "crowded_tile.glsl"
#else
#include "composite_tile.glsl"
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
    finish_tile(at, tile, upper, lower);
}
#else
// Whether a splat comes next. Where no block is behind splats, all that is left is splats.
bool is_splat(uint link) {
    return link != END && !(MIXED && is_block(link));
}

// Lays a tile's entries over one another, front to back; returns what the links of its splats have in common.
uint composite_entries(inout Row upper, inout Row lower, inout Window window, uint tile, uvec2 in_pixels) {
    // Blocks, then splats, and that once where it can be: a loop around the two costs a tenth of all. The splats' condition stands
    // last: first, llvmpipe would run the loop's body once more, with no lane in it, a ninth of the pass.
    uint turns = 0u, splat_links = END, streaks_from = 0u;
    do {
        while (is_block(window.nearest.link)) {
            if (has_streak_layer()) {
                uint to = max(window.nearest.distance2, streaks_from);
                composite_streak_layer(upper, lower, tile, in_pixels, streaks_from, to);
                streaks_from = to;
            }
            composite_block(upper, lower, window.nearest.link);
            take_nearest(window);
        }
        if (is_splat(window.nearest.link)) do {
            if (LOSES_LEFT != 0u && window.taken == END) break;
            splat_links &= window.nearest.link;
            composite_splat(upper, lower, window.nearest.link);
            take_nearest(window);
            if (!MIXED) {
                // Two a pass: CPU drivers write back all of a tile's pixels in each.
                splat_links &= window.nearest.link;
                composite_splat(upper, lower, window.nearest.link);
                take_nearest(window);
            }
        } while (is_splat(window.nearest.link));
    } while (MIXED && window.nearest.link != END && ++turns < MOST_TURNS);
    if (has_streak_layer()) composite_streak_layer(upper, lower, tile, in_pixels, streaks_from, END);
    return splat_links;
}

// llvmpipe stops an invocation's loops after some 65,000 passes: it may leave the longest of lists early, while they are
// drawn or sorted. Then what the first dispatch drew stays, which is nearly in order.
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
    uint sorted = order_tile(tile);
    Window window = open_window(sorted);
    Row upper = NOTHING, lower = NOTHING;
    start_tile(at, tile);
    composite_entries(upper, lower, window, tile, at * TILE);
    if (has_streak_layer() && (streaks_are_cut || window.nearest.link != END)) {
        leave_to_crowd(number, tile, sorted);
        return;
    }
    if (window.taken < entries) {
        atomicAdd(counters.lost, entries - window.taken);
        return;
    }
    finish_tile(at, tile, upper, lower);
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

// Lists a tile whose entries did not come in order. Links of splats, and END, have the bit LINKS, those of blocks do not.
void list_if_disordered(uint tile, Window window, uint splat_links) {
    bool block_behind = (splat_links & LINKS) == 0u;
    if (window.disordered || block_behind || window.nearest.link != END || streaks_are_cut) {
        uint next = atomicAdd(totals.disordered, 1u);
        disordered_tiles[next] = uvec2(tile, window.taken);
        atomicMax(totals.disordered_groups.x, next / 64u + 1u);
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
    Window window = open_window(head_of(tile));
    Row upper = NOTHING, lower = NOTHING;
    start_tile(at, tile);
    uint splat_links = composite_entries(upper, lower, window, tile, at * TILE);
    list_if_disordered(tile, window, splat_links);
    finish_tile(at, tile, upper, lower);
}
#endif
#endif
#endif
