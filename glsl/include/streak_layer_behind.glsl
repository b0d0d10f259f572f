#ifndef STREAK_LAYER_BEHIND_GLSL
#define STREAK_LAYER_BEHIND_GLSL
// What of the streak layer is between two distances, over a tile's pixels.
#include "by_four.glsl"
#include "disc.glsl"
#include "behind.glsl"
#include "streak.glsl"
#include "streak_layer.glsl"

// Optical depths are summed up in whole units, so that no order of the streaks changes a bit.
const float DEPTH_UNITS = 16777216.0;
const ivec4 MOST_DEPTH = ivec4(0x40000000);

// -log(1 - x) within 1.5 % of what passes, and for x to 1: of twice the root of what passes, by a Padé approximant.
ivec4 optical_depth(vec4 x) {
    precise vec4 a = 1.0 + sqrt(1.0 - x);
    precise vec4 depth = x * (12.0 * a - 6.0 * x) / (6.0 * a * (a - x) + x * x);
    return ivec4(depth * DEPTH_UNITS + 0.5);
}

// Is within 0.2 % of that for x up to THIN, without a root and a division, which take half of a streak's time on CPU drivers.
ivec4 thin_optical_depth(vec4 x) {
    precise vec4 depth = x * (1.0 + x * (0.5 + x * (0.3333333 + x * (0.25 + 0.38 * x))));
    return ivec4(depth * DEPTH_UNITS + 0.5);
}

struct Depths {
    ivec4 upper, lower;
};

// Adds what a drop at a squared distance, as bits, covers.
void add_depths(inout Depths depths, uint distance2, ivec4 above, ivec4 below) {
    if (HAS_DEPTH != 0u) {
        above = mix(above, ivec4(0), lessThanEqual(upper_behind2, vec4(uintBitsToFloat(distance2))));
        below = mix(below, ivec4(0), lessThanEqual(lower_behind2, vec4(uintBitsToFloat(distance2))));
    }
    depths.upper = min(depths.upper + above, MOST_DEPTH);
    depths.lower = min(depths.lower + below, MOST_DEPTH);
}

// A link's record, and the next link.
uvec2 link_at(uint link) {
    if (BY_TEXELS != 0u) return texelFetch(link_texels, int(STREAK_HEADS / 2u + link)).xy;
    return uvec2(streak_layer[STREAK_HEADS + 2u * link], streak_layer[STREAK_HEADS + 2u * link + 1u]);
}

const uint NO_LINK = 0x80000000u; // more than there can be

// The first link of a tile's cell of a kind; `in_pixels`: the tile's corner from that of the first tile.
uint first_link(const uint kind, uvec2 in_pixels) {
    uvec2 cell = in_pixels / CELLS_PX[kind];
    return streak_layer[first_cell(kind) + cell.y * cells_of(kind).x + cell.x];
}

// Adds what a record covers of a tile, if its squared distance, as bits, is from `from` on and under `to`. `first`: its first
// words; `corner`: of the tile in the whole picture.
void add_record(inout Depths depths, const uint kind, uint record, uvec4 first, vec2 corner, uint from, uint to) {
    ivec4 above, below;
    if (kind >= DISCS) {
        Disc d = unpack_disc(first.zw, four_of_nodes(record + 4u));
        if (first.x < from || first.x >= to) d.opacity = 0.0;
        vec2 upper = corner + 0.5 - d.center;
        above = optical_depth(disc_coverage(d, upper));
        below = optical_depth(disc_coverage(d, upper + vec2(0.0, 1.0)));
        add_depths(depths, first.x, above, below);
        return;
    }
    Streak s = unpack_streak(first.zw, four_of_nodes(record + 4u));
    if (first.x < from || first.x >= to) s.area = 0.0;
    vec2 upper = corner + 0.5 - s.center, lower = upper + vec2(0.0, 1.0);
    if (kind == SQUARES) {
        above = optical_depth(streak_coverage(s, upper));
        below = optical_depth(streak_coverage(s, lower));
    } else if (kind == COLUMNS || kind == SHORT_COLUMNS) {
        above = thin_optical_depth(upright_coverage(s, upper));
        below = thin_optical_depth(upright_coverage(s, lower));
    } else {
        s.upright = false;
        above = thin_optical_depth(streak_coverage(s, upper));
        below = thin_optical_depth(streak_coverage(s, lower));
    }
    add_depths(depths, first.x, above, below);
}

// Streaks that an invocation of a GPU walks over, at most: before a watchdog resets the device.
const uint MOST_STREAKS = 65535;

// Whether a walk along a list was ended early: by MOST_STREAKS, or by llvmpipe, which ends all loops of eight invocations after
// 65,535 passes together. A tile walks its lists once before each of its blocks, so some hundred streaks before some dozens of
// blocks take as many. Such tiles are left to crowded_tile.glsl.
bool streaks_are_cut = false;
uint streaks_walked = 0u;

// Adds the streaks of a cell from a squared distance, as bits, to another. (If the loop asked for END itself, a compiler
// would take the check after it for true.)
void add_cell(inout Depths depths, const uint kind, uvec2 in_pixels, vec2 corner, uint from, uint to) {
    uint link = first_link(kind, in_pixels);
    while (link < NO_LINK && (FOR_GPU == 0u || streaks_walked++ < MOST_STREAKS)) {
        uvec2 pair = link_at(link);
        link = pair.y;
        add_record(depths, kind, pair.x, four_of_nodes(pair.x), corner, from, to);
    }
    streaks_are_cut = streaks_are_cut || link != END;
}

// What passes through optical depths is left out of 1.
vec4 cover_of(ivec4 depth) {
    return 1.0 - exp(vec4(depth) * (-1.0 / DEPTH_UNITS));
}

// Optical depths of the streak layer over a tile's pixels; `in_pixels`: its corner from that of the first tile.
Depths streak_layer_depths(uvec2 in_pixels, uint from, uint to) {
    Depths depths = Depths(ivec4(0), ivec4(0));
    vec2 corner = vec2(in_pixels + first_tile() * TILE);
    add_cell(depths, SQUARES, in_pixels, corner, from, to);
    add_cell(depths, COLUMNS, in_pixels, corner, from, to);
    add_cell(depths, ROWS, in_pixels, corner, from, to);
    add_cell(depths, SHORT_COLUMNS, in_pixels, corner, from, to);
    if (HAS_LENS != 0u) {
        add_cell(depths, DISCS, in_pixels, corner, from, to);
        add_cell(depths, WIDE_DISCS, in_pixels, corner, from, to);
    }
    return depths;
}
#endif
