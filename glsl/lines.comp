#version 460
#extension GL_GOOGLE_include_directive : require
// Lines of the brightest source along wide streaks of the streak layer: what they add to each pixel, less what of their light the
// streak layer spreads over the streak; one invocation a part of a streak. They are in front of all other drops, which are
// mostly farther. See src/passes/streak_layer.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#include "nodes_by_four.glsl"
#include "projection.glsl"
#include "appearance.glsl"
#include "far_glints.glsl"
#include "splat_table.glsl"
#include "streak_layer_lines.glsl"
#include "behind.glsl"
#include "streak.glsl"
#include "rounded.glsl"
#include "streak_layer.glsl"

layout(local_size_x = 64) in;

// Each pixel of each tile has a sum in LINE_UNITS, for a light of 1.
layout(std430, set = 1, binding = 7) buffer LineSums { int line_sums[]; };

const float INVERSE_PI = 0.318309886;

// A row of a tile; `from`: its first pixel's middle, from that of the streak.
void add_row(Streak s, Streak first, Streak second, float second_share, uint tile, uint row, vec2 from, float distance2) {
    vec4 brighter = streak_share(first, from + s.center - first.center);
    brighter += second_share * streak_share(second, from + s.center - second.center);
    brighter -= INVERSE_PI * (1.0 + second_share) * streak_coverage(s, from);
    if (HAS_DEPTH != 0u) {
        vec4 behind = behind_of_row(tile, row);
        brighter = mix(vec4(0.0), brighter, greaterThan(behind * behind, vec4(distance2)));
    }
    ivec4 units = ivec4(rounded(clamp(brighter, -1.0, 1000.0) * LINE_UNITS));
    uint at = tile * PIXELS + row * TILE.x;
    if (units.x != 0) atomicAdd(line_sums[at], units.x);
    if (units.y != 0) atomicAdd(line_sums[at + 1u], units.y);
    if (units.z != 0) atomicAdd(line_sums[at + 2u], units.z);
    if (units.w != 0) atomicAdd(line_sums[at + 3u], units.w);
}

// The places of the lines, each where it is: by the ray that shows it, of which the table tells how far from the source it is.
// x and y of the first, z and w of the second.
vec4 places_in_drop(vec2 center, float radius, out float second_share) {
    Lines middle = lines_at(center);
    second_share = middle.second_share;
    return vec4(lines_at(center + radius * middle.first).first, lines_at(center + radius * middle.second).second);
}

void main() {
    uint number = gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (number >= min(totals.line_parts, LINE_PARTS)) return;
    uint record = streak_layer[line_part(number)], part = streak_layer[line_part(number) + 1u];
    uvec4 first = four_of_nodes(record);
    Streak s = unpack_streak(first.zw, four_of_nodes(record + 4u));

    // Along the longer axis the part's pixels, or tiles; across it those that the streak may meet there. Pixels of the whole
    // picture, so that its parts have its bits.
    uvec2 first_pixel = first_tile() * TILE, end_pixel = end_tile() * TILE;
    uint step = s.upright ? 1u : TILE.x, cell = s.upright ? TILE.x : 1u, knot = part * LINE_PART;
    uint begin = max(knot, s.upright ? first_pixel.y : first_pixel.x);
    uint end = min(knot + LINE_PART, s.upright ? end_pixel.y : end_pixel.x);
    vec2 axis = s.upright ? vec2(s.slope, 1.0) : vec2(1.0, s.slope);
    float middle = s.upright ? s.center.y : s.center.x;
    float radius = sqrt(s.area * INVERSE_PI), second_share;
    vec4 low = places_in_drop(s.center + axis * (float(knot) - middle), radius, second_share);
    vec4 high = places_in_drop(s.center + axis * (float(knot + LINE_PART) - middle), radius, second_share);
    float half_width = 1.0 / s.inverse + 0.5 + 0.5 * float(step) * abs(s.slope);
    int least = int((s.upright ? first_pixel.x : first_pixel.y) / cell);
    int most = int((s.upright ? end_pixel.x : end_pixel.y) / cell);
    for (uint along = begin; along < end; along += step) {
        float off = float(along) + 0.5 * float(step) - middle;
        float across = (s.upright ? s.center.x : s.center.y) + s.slope * off;
        float share = (float(along - knot) + 0.5 * float(step)) / float(LINE_PART);
        vec4 places = mix(low, high, share);
        Streak one = line_along(s, places.xy), two = line_along(s, places.zw);
        int from = clamp(int(floor((across - half_width) / float(cell))), least, most);
        int to = clamp(int(floor((across + half_width) / float(cell))), least - 1, most - 1);
        for (int i = from; i <= to; ++i) {
            uvec2 pixel = s.upright ? uvec2(uint(i) * cell, along) : uvec2(along, i), at = pixel / TILE - first_tile();
            uint tile = at.y * tiles_across() + at.x;
            vec2 there = vec2(pixel) + 0.5 - s.center;
            add_row(s, one, two, second_share, tile, pixel.y % TILE.y, there, uintBitsToFloat(first.x));
        }
    }
}
