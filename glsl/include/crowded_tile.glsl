#ifndef CROWDED_TILE_GLSL
#define CROWDED_TILE_GLSL
// A tile whose streaks are too many for one invocation, as its lists are walked once before each of its blocks. Here a
// workgroup walks them once for all of its blocks: each turn takes one streak for each invocation, which finds between
// which blocks it lies, and adds to the sums there. Sums are in whole units, so that the picture is that of one invocation.
//
// llvmpipe ends an invocation's loops after 65,535 passes together, so a million streaks over one tile are drawn; what is
// beyond is counted. Needs all that composite.comp includes.

#include "composite_tile.glsl"

const uint CROWD = 16; // invocations that draw a tile
layout(local_size_x = CROWD) in;

const uint INTERVALS = 128; // before, between and behind blocks; a tile with more walks its lists again
const uint NO_RECORD = 0xffffffffu;

shared uint interval_from[INTERVALS]; // squared distance, as bits, from which on a streak is in it; END: none is
shared uint interval_sums[INTERVALS * PIXELS];

// Goes to the next link, and takes its record if it is this invocation's.
void take_link(inout uint link, inout uint record, uint whose) {
    bool there = link < NO_LINK;
    uvec2 pair = link_at(there ? link : 0u);
    if (there && gl_LocalInvocationID.x == whose) record = pair.x;
    if (there) link = pair.y;
}

// No loop, whose passes would count.
void take_four(inout uint link, inout uint record, uint whose) {
    take_link(link, record, whose);
    take_link(link, record, whose + 1u);
    take_link(link, record, whose + 2u);
    take_link(link, record, whose + 3u);
}

// The last interval that begins at a squared distance or before; no loop either.
uint interval_of(uint distance2) {
    uint at = interval_from[64] <= distance2 ? 64u : 0u;
    at += interval_from[at + 32u] <= distance2 ? 32u : 0u;
    at += interval_from[at + 16u] <= distance2 ? 16u : 0u;
    at += interval_from[at + 8u] <= distance2 ? 8u : 0u;
    at += interval_from[at + 4u] <= distance2 ? 4u : 0u;
    at += interval_from[at + 2u] <= distance2 ? 2u : 0u;
    return at + (interval_from[at + 1u] <= distance2 ? 1u : 0u);
}

// A sum that is full takes no more: sixteen at once cannot bring it beyond 32 bits. (Without a branch: llvmpipe 22.3.6 also
// runs what no lane asks for.)
void add_sum(uint at, int depth) {
    bool full = interval_sums[at] >= uint(MOST_DEPTH.x);
    atomicAdd(interval_sums[at], full ? 0u : uint(depth));
}

void add_sums(uint first, ivec4 depths) {
    add_sum(first, depths.x);
    add_sum(first + 1u, depths.y);
    add_sum(first + 2u, depths.z);
    add_sum(first + 3u, depths.w);
}

// Adds the streaks of a cell to the sums of their intervals, if they are nearer than `to`.
void share_cell(const uint kind, uvec2 in_pixels, vec2 corner, uint to) {
    uint link = first_link(kind, in_pixels), from = interval_from[0];
    while (link < NO_LINK) {
        uint record = NO_RECORD;
        take_four(link, record, 0u);
        take_four(link, record, 4u);
        take_four(link, record, 8u);
        take_four(link, record, 12u);
        bool is_one = record != NO_RECORD;
        uint node = is_one ? record : 0u;
        uvec4 first = four_of_nodes(node);
        Depths depths = Depths(ivec4(0), ivec4(0));
        add_record(depths, kind, node, first, corner, from, to);
        // What stands in the first node may be no streak, nor a number.
        if (!is_one) depths = Depths(ivec4(0), ivec4(0));
        uint sums = interval_of(first.x) * PIXELS;
        add_sums(sums, depths.upper);
        add_sums(sums + TILE.x, depths.lower);
    }
    if (link != END && gl_LocalInvocationID.x == 0u) atomicAdd(counters.lost, 1u);
}

ivec4 four_sums(uint first) {
    uvec4 sums = uvec4(interval_sums[first], interval_sums[first + 1u], interval_sums[first + 2u], interval_sums[first + 3u]);
    return ivec4(min(sums, uvec4(MOST_DEPTH)));
}

Depths depths_of_interval(uint interval) {
    return Depths(four_sums(interval * PIXELS), four_sums(interval * PIXELS + TILE.x));
}

// Every invocation does all but the sums; the first one writes.
// Empties the sums, and begins an interval before each block from `link` on, as far as there is room; returns the link of the
// next. `from`: where the first interval begins; then the last.
uint open_intervals(uint link, inout uint from) {
    uint in_group = gl_LocalInvocationID.x;
    for (uint i = in_group; i < INTERVALS; i += CROWD) interval_from[i] = END;
    for (uint i = in_group; i < INTERVALS * PIXELS; i += CROWD) interval_sums[i] = 0u;
    barrier();
    if (in_group == 0u) interval_from[0] = from;
    uint next = link, intervals = 1u;
    while (next != END && intervals < INTERVALS) {
        if (is_block(next)) {
            from = max(nodes[node_of(next)], from);
            if (in_group == 0u) interval_from[intervals] = from;
            ++intervals;
        }
        next = nodes[next];
    }
    barrier();
    return next;
}

// Adds all streaks and discs of the tile's cells.
void share_cells(uvec2 in_pixels, vec2 corner, uint to) {
    share_cell(SQUARES, in_pixels, corner, to);
    share_cell(COLUMNS, in_pixels, corner, to);
    share_cell(ROWS, in_pixels, corner, to);
    share_cell(SHORT_COLUMNS, in_pixels, corner, to);
    if (HAS_LENS != 0u) {
        share_cell(DISCS, in_pixels, corner, to);
        share_cell(WIDE_DISCS, in_pixels, corner, to);
    }
}

void main() {
    uint number = group_number(), in_group = gl_LocalInvocationID.x;
    if (number >= totals.crowded) return;
    uvec2 numbered = disordered_tiles[disordered_tiles[TILE_COUNT + number].x];
    uint tile = numbered.x, entries = numbered.y, link = heads[tile], taken = 0u, from = 0u;
    uvec2 at = place_of_tile(tile), in_pixels = at * TILE;
    vec2 corner = vec2(in_pixels + first_tile() * TILE);
    Row upper = NOTHING, lower = NOTHING;
    start_tile(at, tile);

    do {
        uint next = open_intervals(link, from);
        uint to = next == END ? END : from;
        share_cells(in_pixels, corner, to);
        barrier();
        uint interval = 0u;
        while (link != next) {
            if (is_block(link)) {
                composite_depths(upper, lower, tile, depths_of_interval(interval++));
                composite_block(upper, lower, link);
            } else {
                composite_splat(upper, lower, link);
            }
            ++taken;
            link = nodes[link];
        }
        if (link == END) composite_depths(upper, lower, tile, depths_of_interval(interval));
        barrier();
    } while (link != END);

    if (in_group != 0u) return;
    // Some were left out while they were put in order.
    if (taken < entries) atomicAdd(counters.lost, entries - taken);
    finish_tile(tile, upper, lower);
}
#endif
