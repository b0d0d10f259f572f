#version 460
#extension GL_GOOGLE_include_directive : require
// Lines of the brightest source along wide streaks of the veil: what they add to each pixel, less what of their light the
// veil spreads over the streak; one invocation a part of a streak. They are in front of all other drops, which are
// mostly farther. See src/passes/veil.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#define NODES_BINDING 25
#include "nodes_by_four.glsl"
#include "projection.glsl"
#define REACH_BINDING 20
#include "reach.glsl"
#include "streak.glsl"
#define VEIL_BINDING 21
#define VEIL_READ_ONLY
#include "veil.glsl"

layout(local_size_x = 64) in;

// After all tiles' light: of each tile the places of the two lines, and how much of the first one's light the second has
// (veil_light.comp).
layout(std430, set = 0, binding = 22) readonly buffer VeilLight { uvec4 veil_light[]; };
#include "veil_lines.glsl"
// Of the pixels of each tile, in LINE_UNITS, for a light of 1.
layout(std430, set = 0, binding = 29) buffer LineSums { int line_sums[]; };

const float INVERSE_PI = 0.318309886;

// A row of a tile; `from`: its first pixel's middle, from that of the streak.
void add_row(Streak s, Streak first, Streak second, float second_share, uint tile, uint row, vec2 from, float distance2) {
    vec4 brighter = streak_share(first, from + s.center - first.center);
    brighter += second_share * streak_share(second, from + s.center - second.center);
    brighter -= INVERSE_PI * (1.0 + second_share) * streak_coverage(s, from);
    if (HAS_DEPTH != 0u) {
        vec4 behind = reach_of_row(tile, row);
        brighter = mix(vec4(0.0), brighter, greaterThan(behind * behind, vec4(distance2)));
    }
    ivec4 units = ivec4(round(clamp(brighter, -1.0, 1000.0) * LINE_UNITS));
    uint at = tile * PIXELS + row * TILE.x;
    if (units.x != 0) atomicAdd(line_sums[at], units.x);
    if (units.y != 0) atomicAdd(line_sums[at + 1u], units.y);
    if (units.z != 0) atomicAdd(line_sums[at + 2u], units.z);
    if (units.w != 0) atomicAdd(line_sums[at + 3u], units.w);
}

// Where the lines are, in radii from the middle of a drop, and how much of the first one's light the second has: of the
// tile at a place from the first tile's corner, or of the nearest.
uvec4 lines_at(vec2 place) {
    uvec2 tile = uvec2(clamp(place, vec2(0.0), vec2(veil_size()) - 1.0)) / TILE;
    return veil_light[TILE_COUNT + tile.y * tiles_across() + tile.x];
}

// The same where each line is: there the ray that shows it points, of which the table tells how far from the source it is.
// x and y of the first, z and w of the second.
vec4 lines_of_drop(vec2 place, float radius, out float second_share) {
    uvec4 middle = lines_at(place);
    second_share = uintBitsToFloat(middle.z);
    vec2 first = unpackHalf2x16(lines_at(place + radius * unpackHalf2x16(middle.x)).x);
    return vec4(first, unpackHalf2x16(lines_at(place + radius * unpackHalf2x16(middle.y)).y));
}

void main() {
    uint number = gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (number >= min(totals.line_parts, LINE_PARTS)) return;
    uint record = veil[line_part(number)], part = veil[line_part(number) + 1u];
    uvec4 first = four_of_nodes(record);
    Streak s = unpack_streak(first.zw, four_of_nodes(record + 4u));

    // Along the longer axis the part's pixels, or tiles; across it those that the streak may meet there.
    vec2 at = s.center - vec2(first_tile() * TILE);
    uvec2 size = veil_size();
    uint step = s.upright ? 1u : TILE.x, cell = s.upright ? TILE.x : 1u;
    uint begin = part * LINE_PART, end = min(begin + LINE_PART, s.upright ? size.y : size.x);
    vec2 axis = s.upright ? vec2(s.slope, 1.0) : vec2(1.0, s.slope);
    float middle = s.upright ? at.y : at.x;
    float radius = sqrt(s.area * INVERSE_PI), second_share;
    vec4 low = lines_of_drop(at + axis * (float(begin) - middle), radius, second_share);
    vec4 high = lines_of_drop(at + axis * (float(end) - middle), radius, second_share);
    float half_width = 1.0 / s.inverse + 0.5 + 0.5 * float(step) * abs(s.slope);
    int cells = int((s.upright ? size.x : size.y) / cell);
    for (uint along = begin; along < end; along += step) {
        float off = float(along) + 0.5 * float(step) - middle, across = (s.upright ? at.x : at.y) + s.slope * off;
        float share = (float(along) + 0.5 * float(step) - float(begin)) / float(LINE_PART);
        vec4 places = mix(low, high, share);
        Streak one = line_along(s, places.xy), two = line_along(s, places.zw);
        int from = clamp(int(floor((across - half_width) / float(cell))), 0, cells);
        int to = clamp(int(floor((across + half_width) / float(cell))), -1, cells - 1);
        for (int i = from; i <= to; ++i) {
            uvec2 pixel = s.upright ? uvec2(uint(i) * cell, along) : uvec2(along, i);
            uint tile = pixel.y / TILE.y * tiles_across() + pixel.x / TILE.x;
            vec2 there = vec2(pixel) + 0.5 - at;
            add_row(s, one, two, second_share, tile, pixel.y % TILE.y, there, uintBitsToFloat(first.x));
        }
    }
}
