#ifndef GLINT_LIGHT_GLSL
#define GLINT_LIGHT_GLSL
// The light of a bright source's image goes to the pixels of its drop's tile fragments: to one of them, along a line or
// over an ellipse. SHARED: the invocations of a workgroup part them.
#include "appearance.glsl"
#include "behind.glsl"
#include "by_four.glsl"
#include "glint_turns.glsl"
#include "shared_exponent.glsl"
#include "tile_buffers.glsl"

// Invocations of a workgroup (src/gpu/machine.rs).
layout(constant_id = 26) const uint GLINT_LANES = 8;
const uint WIDE = GLINT_LANES;

// How many sources and blocks there are: read before any branch, where CPU drivers read what is the same for all lanes once.
uint all_sources, all_blocks;

void read_counts() {
    all_sources = source_count.x;
    all_blocks = min(totals.blocks, block_room());
}

// Invocations of SHARED part the pixels between them, by rows of tiles; of a drop that moves by columns of pixels, if its
// way is longer across.
#ifdef SHARED
bool is_mine(int number) { return uint(number) % WIDE == gl_LocalInvocationID.x; }
#else
bool is_mine(int number) { return true; }
#endif

// Part of a pixel that a fragment must cover to take light: a colour counts as much as its pixel is covered, so that
// a little part would have to be brighter than a colour can be.
const float LEAST_COVER = 1.0 / 32.0;
// The least part for a drop that is spread, by a lens or its motion: no pixel takes more than its share of the light, however
// little it is covered.
const float LEAST_SPREAD_COVER = 1.0 / 1024.0;

// The node of a drop's fragment of a tile on the screen; NO_NODE where it has none.
const uint NO_NODE = ~0u;
uint node_of(uint drop, Large r, uvec2 tile) {
    uvec2 first = uvec2(r.first_tile & 0xffffu, r.first_tile >> 16);
    if (any(lessThan(tile, first)) || tile.x - first.x >= r.across) return NO_NODE;
    uint block = r.first_block + (tile.y - first.y) * r.across + tile.x - first.x;
    return block < all_blocks && large_of_block(block) == drop ? block_node(block) : NO_NODE;
}

uint place_in_tile(uvec2 pixel) {
    return pixel.y % TILE.y * TILE.x + pixel.x % TILE.x;
}

// How much of a drop around a place on the screen is before what is behind there.
float share_before_depth(Large r, vec2 at) {
    uvec2 pixel = uvec2(at);
    return HAS_DEPTH != 0u ? share_before(r.sphere, at, distance_behind[tile_number(pixel / TILE) * PIXELS + place_in_tile(pixel)]) : 1.0;
}

// Adds light to a pixel of a fragment of a drop, if that covers at least a part of it; whether it does.
bool add_light_to(uint node, Large r, uvec2 pixel, vec3 light, float least, bool mine) {
    uint in_tile = place_in_tile(pixel);
    float before = share_before_depth(r, vec2(pixel) + 0.5);
    if (before == 0.0) return true;
    uint covered = one_of_nodes(node + COVERAGE + in_tile / 2u) >> 16u * (in_tile & 1u) & 0xffffu;
    uint color = nodes[node + COLORS + in_tile];
    float share = float(covered) / float(r.look >> 16);
    // The image is not drawn elsewhere because a part of what the drop covers of the pixel is hidden.
    if (share < least * before || color == NO_COLOR) return false;
    if (share < least) return HAS_DEPTH != 0u;
    if (mine) nodes[node + COLORS + in_tile] = pack_radiance(unpack_radiance(color) + light / share);
    return true;
}

// Adds light at a place on the screen, if a fragment of the drop is there that covers at least a part of the pixel.
bool add_light_at(uint drop, Large r, vec2 at, vec3 light, float least, bool mine) {
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, frame.image.xy))) return false;
    uvec2 pixel = uvec2(at);
    uint node = node_of(drop, r, pixel / TILE);
    if (node == NO_NODE) return false;
    if (share_before_depth(r, at) < 0.5) return true;
    return add_light_to(node, r, pixel, light, least, mine);
}

#ifdef SHARED
// Adds light of a drop out of focus over a spot (glint_spot.glsl). Each invocation has rows of tiles of its own.
void add_spot_of_light(uint drop, Large r, vec2 at, vec3 light, Spot e) {
    if (is_pointed(e)) {
        if (!take_turns(POINTS)) return;
        for (uint i = 0u; i < POINTS; ++i) {
            vec2 point = at + point_of(e, i);
            add_light_at(drop, r, point, light / float(POINTS), LEAST_SPREAD_COVER, is_mine(int(point.y) / int(TILE.y)));
        }
        return;
    }
    e = broadened(e);
    vec2 wide = sqrt(e.form.xz) + 0.5 * abs(e.way) + 0.5, low = max(floor(at - wide), 0.0), high = min(floor(at + wide), frame.image.xy - 1.0);
    uvec2 first = uvec2(r.first_tile & 0xffffu, r.first_tile >> 16);
    if (any(greaterThan(low, high))) return;
    uvec2 from = max(uvec2(low) / TILE, first), to = min(uvec2(high) / TILE, uvec2(first.x + r.across - 1u, ~0u));
    if (any(greaterThan(from, to))) return;
    if (!take_turns(((to.y - from.y) / WIDE + 1u) * (to.x - from.x + 2u))) return;
    light /= area_of(e);
    vec3 inside = inverse_of(e.form);
    for (uint row = from.y + (gl_LocalInvocationID.x + WIDE - from.y % WIDE) % WIDE; row <= to.y; row += WIDE) {
        for (uint column = from.x; column <= to.x; ++column) {
            uint node = node_of(drop, r, uvec2(column, row));
            // Unrolled, they take no turns of their own.
            [[unroll]] for (uint i = 0u; i < PIXELS; ++i) {
                uvec2 pixel = uvec2(column, row) * TILE + uvec2(i % TILE.x, i / TILE.x);
                vec2 off = vec2(pixel) + 0.5 - at;
                float part = node != NO_NODE && all(lessThan(pixel, uvec2(frame.image.xy))) ? part_of_spot(e, inside, off) : 0.0;
                if (part > 0.0) add_light_to(node, r, pixel, part * light, LEAST_SPREAD_COVER, true);
            }
        }
    }
}
#endif

// Adds light of a drop that moves while the shutter is open, by the length of its way in each column of pixels, or in each row
// if that is longer. Of SHARED each invocation has columns, or rows, of its own.
void add_line_of_light(uint drop, Large r, vec2 at, vec3 light, vec2 way) {
    bool is_across = abs(way.x) > abs(way.y);
    float length = is_across ? way.x : way.y, slope = (is_across ? way.y : way.x) / length;
    if (abs(length) < 1e-3) {
        add_light_at(drop, r, at, light, LEAST_COVER, is_mine(int(floor(is_across ? at.x : at.y))));
        return;
    }
    float middle = is_across ? at.x : at.y, end = is_across ? frame.image.x : frame.image.y;
    float from = max(middle - 0.5 * abs(length), 0.0), to = min(middle + 0.5 * abs(length), end);
    if (from >= to) return;
    int first = int(floor(from)), last = int(ceil(to)) - 1, stride = 1;
#ifdef SHARED
    stride = int(WIDE);
    if (!take_turns(uint((last - first) / stride + 1))) return;
    first += int((gl_LocalInvocationID.x + WIDE - uint(first) % WIDE) % WIDE);
#endif
    int i = first;
    if (i <= last) do {
        float low = max(from, float(i)), high = min(to, float(i + 1));
        // Within a column the line crosses into another row at most once.
        float aside = is_across ? at.y : at.x, row = max(floor(aside + slope * (low - middle)), floor(aside + slope * (high - middle)));
        float crossing = slope != 0.0 ? clamp(middle + (row - aside) / slope, low, high) : high;
        for (uint part = 0u; part < 2u; ++part) {
            float along = 0.5 * (part == 0u ? low + crossing : crossing + high) - middle, share = part == 0u ? crossing - low : high - crossing;
            vec2 place = is_across ? vec2(along, slope * along) : vec2(slope * along, along);
            if (share > 0.0) add_light_at(drop, r, at + place, light * (share / abs(length)), LEAST_SPREAD_COVER, true);
        }
        i += stride;
    } while (i <= last);
}

// Adds light to a drop at rest as `add_light_at` does; to another it adds all that falls on its fragments, over the ellipse that the
// lens makes of it.
bool add_light(uint drop, Large r, vec2 at, vec3 light, Spot e) {
    if (!is_spread()) return add_light_at(drop, r, at, light, LEAST_COVER, is_mine(int(at.y) / int(TILE.y)));
    bool is_blurred = HAS_LENS != 0u && moves[2u * drop].w > 0.0;
#ifdef SHARED
    if (is_blurred) add_spot_of_light(drop, r, at, light, e.is_soft ? moved(e) : e);
#endif
    if (!is_blurred) add_line_of_light(drop, r, at, light, e.way);
    return true;
}
#endif
