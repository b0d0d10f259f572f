#ifndef COMPOSITE_TILE_GLSL
#define COMPOSITE_TILE_GLSL
// How entries of a tile's list lie over one another: what all variants of composite.comp share.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "splat.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(constant_id = 17) const uint LOG_SUMS = 0; // 1: the display needs the log average
layout(constant_id = 18) const uint PREFETCH = 0; // 1: see `prefetch_nodes`
layout(constant_id = 19) const uint GLINTS = 0;   // sources of which splats have glints, at most (src/passes/glints.rs)
layout(constant_id = 24) const uint LIST = 0;     // which of `drawn_tiles`
layout(constant_id = 20) const uint LAYERS = 0;   // 1: premultiplied light over nothing, and its opacity
// The result: four halves a pixel, row by row.
layout(std430, set = 1, binding = 0) writeonly buffer Radiance { uvec2 radiance_out[]; };
// For each tile the sum of its pixels' log(delta + luminance).
layout(std430, set = 1, binding = 2) writeonly buffer LogSums { float log_sums[]; };
// The tiles whose lists the window did not bring into order: number, and entries. From TILE_COUNT on: which of them are
// crowded.
layout(std430, set = 1, binding = 3) buffer Disordered { uvec2 disordered_tiles[]; };

layout(std430, set = 1, binding = 22) readonly buffer Shapes { vec4 shapes[]; };

#include "splat_table.glsl"
#include "by_hand.glsl"
#include "far_glints.glsl"
#include "flat_rain.glsl"
#include "by_four.glsl"
#include "projection.glsl"
#include "shape.glsl"
#include "divided.glsl"
#include "rounded.glsl"
#include "behind.glsl"
#include "nearest.glsl"
#include "tile_window.glsl"
#include "tile_order.glsl"
#include "streak.glsl"
#include "disc.glsl"
#include "streak_layer.glsl"
#include "drawn_tiles.glsl"

const vec4 MOST_HALF = vec4(65504.0);
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

// A row of a tile's pixels: the light so far, and the share of what is behind that passes. Vectors, not
// arrays: SwiftShader keeps an array that a loop indexes in memory.
struct Row {
    vec4 r, g, b, through;
};

// Precise: a tile has the same colours whichever of the two pipelines draws it.
void composite_row(inout Row row, vec4 coverage, vec4 r, vec4 g, vec4 b) {
    precise vec4 share = row.through * coverage;
    precise vec4 sum_r = fma(share, r, row.r), sum_g = fma(share, g, row.g), sum_b = fma(share, b, row.b);
    precise vec4 through = row.through - share;
    row = Row(sum_r, sum_g, sum_b, through);
}

// The part of a splat in a row of pixels: what it has of each column, and of the row; its light in a column it fills.
void composite_part(inout Row row, vec4 columns, float height, vec3 light) {
    precise vec4 share = row.through * columns;
    precise vec4 sum_r = fma(share, vec4(light.r), row.r), sum_g = fma(share, vec4(light.g), row.g);
    precise vec4 sum_b = fma(share, vec4(light.b), row.b);
    precise vec4 through = row.through - share * height;
    row = Row(sum_r, sum_g, sum_b, through);
}

// Adds light to pixels that `hit` marks, as far as the drops before let it pass.
void add_light(inout Row row, vec4 hit, vec3 light) {
    precise vec4 share = row.through * hit;
    precise vec4 r = fma(share, vec4(light.r), row.r), g = fma(share, vec4(light.g), row.g);
    precise vec4 b = fma(share, vec4(light.b), row.b);
    row = Row(r, g, b, row.through);
}

// A point of light `at` pixels from the first pixel's corner.
void add_glint(inout Row upper, inout Row lower, vec2 at, vec3 light, bvec4 upper_hidden, bvec4 lower_hidden) {
    vec2 pixel = floor(at);
    vec4 column = vec4(equal(vec4(pixel.x), vec4(0.0, 1.0, 2.0, 3.0)));
    vec4 above = pixel.y == 0.0 ? column : vec4(0.0), below = pixel.y == 1.0 ? column : vec4(0.0);
    if (HAS_DEPTH != 0u) {
        above = mix(above, vec4(0.0), upper_hidden);
        below = mix(below, vec4(0.0), lower_hidden);
    }
    add_light(upper, above, light);
    add_light(lower, below, light);
}

// One colour after the other: together they take more of a GPU's registers.
void composite_row_of_colors(inout Row row, uvec4 colors, uvec2 coverage) {
    vec4 alpha = vec4(unpackUnorm2x16(coverage.x), unpackUnorm2x16(coverage.y)), scale = scales_of(colors);
    precise vec4 share = row.through * mix(alpha, vec4(0.0), equal(colors, uvec4(NO_COLOR)));
    precise vec4 through = row.through - share;
    precise vec4 r = fma(share, vec4(colors & 511u) * scale, row.r);
    precise vec4 g = fma(share, vec4((colors >> 9) & 511u) * scale, row.g);
    precise vec4 b = fma(share, vec4((colors >> 18) & 511u) * scale, row.b);
    row = Row(r, g, b, through);
}

void write_pixel(uint at, uint rg, uint ba, uvec2 nearest) {
    radiance_out[at] = uvec2(rg, ba);
    if (NEAREST != 0u) nearest_drops[at] = nearest;
}

// Lays the sky behind a row and writes what of it is drawn; returns the sum of its log(delta + luminance). `first`:
// from the first pixel that is drawn, modulo 2^32, so that pixels before it are beyond the size.
float finish(Row row, Nearest nearest, uint behind, uvec2 first) {
    uvec4 left = two_of_sky(behind), right = two_of_sky(behind + 2u);
    vec4 rg_left = vec4(unpackHalf2x16(left.x), unpackHalf2x16(left.z));
    vec4 rg_right = vec4(unpackHalf2x16(right.x), unpackHalf2x16(right.z));
    vec4 b = vec4(unpackHalf2x16(left.y).x, unpackHalf2x16(left.w).x,
                  unpackHalf2x16(right.y).x, unpackHalf2x16(right.w).x);
    vec4 alpha = vec4(1.0);
    if (LAYERS != 0u) {
        vec4 hidden = vec4(unpackHalf2x16(left.y).y, unpackHalf2x16(left.w).y,
                           unpackHalf2x16(right.y).y, unpackHalf2x16(right.w).y);
        alpha = 1.0 - row.through * (1.0 - hidden);
    }
    composite_row(row, vec4(1.0), vec4(rg_left.xz, rg_right.xz), vec4(rg_left.yw, rg_right.yw), b);
    if (GLINTS != 0u && has_streak_layer()) {
        // In front of all.
        vec4 share = vec4(lines_of_row(behind / TILE.x)) * (1.0 / LINE_UNITS);
        vec3 light = unpack_radiance(streak_layer_of_tile(behind / PIXELS).z);
        precise vec4 r = fma(share, vec4(light.r), row.r), g = fma(share, vec4(light.g), row.g);
        precise vec4 b = fma(share, vec4(light.b), row.b);
        row = Row(r, g, b, row.through);
    }
    // Glints may lie in one pixel until it is beyond what a half holds; a line's spread light may be behind a drop.
    row.r = clamp(row.r, vec4(0.0), MOST_HALF);
    row.g = clamp(row.g, vec4(0.0), MOST_HALF);
    row.b = clamp(row.b, vec4(0.0), MOST_HALF);

    uvec2 size = frame.window.zw;
    uint at = first.y * size.x + first.x;
    bvec4 drawn = lessThan(first.x + uvec4(0, 1, 2, 3), uvec4(first.y < size.y ? size.x : 0u));
    uvec4 rg = half_bits(row.r) | half_bits(row.g) << 16, ba = half_bits(row.b) | half_bits(clamp(alpha, 0.0, 1.0)) << 16;
    if (drawn.x) write_pixel(at, rg.x, ba.x, uvec2(nearest.record.x, nearest.count.x));
    if (drawn.y) write_pixel(at + 1u, rg.y, ba.y, uvec2(nearest.record.y, nearest.count.y));
    if (drawn.z) write_pixel(at + 2u, rg.z, ba.z, uvec2(nearest.record.z, nearest.count.z));
    if (drawn.w) write_pixel(at + 3u, rg.w, ba.w, uvec2(nearest.record.w, nearest.count.w));
    precise vec4 luminance = LUMINANCE.r * row.r + LUMINANCE.g * row.g + LUMINANCE.b * row.b;
    // Logarithms of products of two, which stay within a float.
    vec4 shifted = mix(vec4(1.0), frame.tone.y + luminance, drawn);
    vec2 logs = log(shifted.xy * shifted.zw);
    return logs.x + logs.y;
}

// The tile's first pixel, from the view axis; one over the focal length in pixels.
vec2 plane_corner;
float inverse_focal;
// Where the first source is, in the splats' table.
uvec4 first_source;
// Their nearest drops so far.
Nearest upper_nearest, lower_nearest;
#include "streak_layer_behind.glsl"

void composite_block(inout Row upper, inout Row lower, uint link) {
    uint node = node_of(link), record = NEAREST != 0u ? large_record(large_of_block(block_of_node(node))) : 0u;
    uvec4 coverage = four_of_nodes(node + COVERAGE);
    // One row after the other: together they take more of a GPU's registers.
    uvec4 colors = four_of_nodes(node + COLORS);
    if (NEAREST != 0u) meet(upper_nearest, met_by_block(coverage.xy, colors), record);
    composite_row_of_colors(upper, colors, coverage.xy);
    colors = four_of_nodes(node + COLORS + TILE.x);
    if (NEAREST != 0u) meet(lower_nearest, met_by_block(coverage.zw, colors), record);
    composite_row_of_colors(lower, colors, coverage.zw);
}

// Gives the colours of a sphere's halves the mean light of a flattened drop.
void flatten_colors(inout vec3 upper, inout vec3 lower, vec3 of_flat, float flatness) {
    vec3 round = 0.5 * (upper + lower);
    precise vec3 shown = flattened_light(round, of_flat, flatness);
    precise vec3 share = shown / max(round, 1e-30);
    precise vec3 above = upper * share, below = lower * share;
    upper = above;
    lower = below;
}

// An entry that is no splat covers nothing.
void composite_splat(inout Row upper, inout Row lower, uint link) {
    bool splat = link != END && !is_block(link);
    uvec4 words = four_of_nodes(splat ? node_of(link) : 0u);
    if (!splat) words.w = 0u;
    // The centre is told from the corner of the splat's first tile: 0, or 1 to the right, 2 and 3 below.
    uint which = link & 3u;
    vec2 half_sides = unpack_half_sides(words.w);
    bool spread = is_spread();
    vec2 from = vec2(uvec2(which & 1u, which >> 1) * TILE) - splat_center(words.z);
    uint direction = words.w >> HALF_SIDES_BITS;
    uvec4 shown = splat_of(direction);
    // A splat is hidden where its centre is farther than what is behind.
    float distance2 = uintBitsToFloat(words.x);
    bvec4 upper_hidden = lessThanEqual(upper_behind2, vec4(distance2));
    bvec4 lower_hidden = lessThanEqual(lower_behind2, vec4(distance2));
    // The disc's area is the box's.
    float squared = half_sides.x * half_sides.y / 0.78539816;
    if (spread) squared *= unpack_opacity(words.z);
    vec2 center = plane_corner - from;
    float away2 = dot(center, center) + frame.image.z * frame.image.z, near = inversesqrt(away2);
    vec3 axis = near * vec3(center.x, -center.y, -frame.image.z);
    float radius = sqrt(squared * away2 * near * inverse_focal); // over the root of the axis' depth
    float flatness = 0.0;
    vec3 of_flat = vec3(0.0);
    if (has_flat()) {
        precise float mm = field.shown.w * frame.image.z * near * near * radius * sqrt(distance2);
        flatness = FLAT_RAIN != 0u ? flatness_of(mm) : 0.0;
        if (is_by_hand(words.y)) flatness = FLAT_PLACED != 0u ? flatness_of_shape(shapes[BY_HAND + by_hand_number(words.y)]) : 0.0;
        of_flat = flat_splats_light(shown.zw, flatness);
    }
    // Late: they take a GPU's registers.
    vec3 upper_color = unpack_radiance(shown.x), lower_color = unpack_radiance(shown.y);
    if (has_flat()) flatten_colors(upper_color, lower_color, of_flat, flatness);
    for (uint i = 0u; i < GLINTS; ++i) {
        uvec4 source = i == 0u ? first_source : splat_of(TOWARD_SOURCES + i);
        if (i > 0u && source.w == 0u) break;
        vec3 toward = uintBitsToFloat(source.xyz);
        uvec4 glints = splat_of(ANGLES + i * GLINT_ANGLES + angle_number(dot(axis, toward)));
        vec3 first_light = unpack_radiance(glints.y), second_light = unpack_radiance(glints.z);
        if (HAS_LENS != 0u && spread && (words.z & IS_FAINT) != 0u) {
            // A splat out of focus spreads them as all of its light.
            upper_color += (first_light + second_light) * (1.0 / 3.14159265);
            lower_color += (first_light + second_light) * (1.0 / 3.14159265);
        } else {
            vec2 places = radius * unpackHalf2x16(glints.x), on_screen = toward_on_screen(axis, toward);
            add_glint(upper, lower, places.x * on_screen - from, squared * first_light, upper_hidden, lower_hidden);
            add_glint(upper, lower, places.y * on_screen - from, squared * second_light, upper_hidden, lower_hidden);
        }
    }
    // What each column of pixels has of the box, and each row of its upper and its lower half.
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 columns = clamp(half_sides.x - x, 0.0, 1.0) - clamp(-half_sides.x - x, 0.0, 1.0);
    bvec4 met = greaterThan(columns, vec4(0.0));
    if (spread) columns *= unpack_opacity(words.z);
    vec2 y = from.y + vec2(0.0, 1.0), middle = clamp(-y, 0.0, 1.0);
    vec2 above = middle - clamp(-half_sides.y - y, 0.0, 1.0), below = clamp(half_sides.y - y, 0.0, 1.0) - middle;
    precise vec3 first = fma(lower_color, vec3(below.x), upper_color * above.x);
    precise vec3 second = fma(lower_color, vec3(below.y), upper_color * above.y);
    precise vec2 rows = above + below;
    vec4 above_columns = columns, below_columns = columns;
    if (HAS_DEPTH != 0u) {
        above_columns = mix(columns, vec4(0.0), upper_hidden);
        below_columns = mix(columns, vec4(0.0), lower_hidden);
    }
    if (NEAREST != 0u) {
        bvec4 upper_met = both(met, bvec4(rows.x > 0.0)), lower_met = both(met, bvec4(rows.y > 0.0));
        if (HAS_DEPTH != 0u) {
            upper_met = both(upper_met, not(upper_hidden));
            lower_met = both(lower_met, not(lower_hidden));
        }
        meet(upper_nearest, upper_met, node_of(link) / NODE);
        meet(lower_nearest, lower_met, node_of(link) / NODE);
    }
    composite_part(upper, above_columns, rows.x, first);
    composite_part(lower, below_columns, rows.y, second);
}

// Lays streaks of so great optical depths behind a tile's pixels.
void composite_depths(inout Row upper, inout Row lower, uint tile, Depths depths) {
    uvec4 words = streak_layer_of_tile(tile);
    vec3 light = vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
    composite_row(upper, cover_of(depths.upper), vec4(light.r), vec4(light.g), vec4(light.b));
    composite_row(lower, cover_of(depths.lower), vec4(light.r), vec4(light.g), vec4(light.b));
}

// Lays what of the streak layer is from a squared distance to another, as bits, behind a tile's pixels.
void composite_streak_layer(inout Row upper, inout Row lower, uint tile, uvec2 in_pixels, uint from, uint to) {
    composite_depths(upper, lower, tile, streak_layer_depths(in_pixels, from, to));
}

// Whether blocks behind splats are drawn here. Drops of one size look larger the nearer they are, so a block is in
// front of all splats. That does not hold if sizes differ, nor in tiles that the first dispatch found in disorder.
#if defined(DISORDERED) || defined(LONG)
const bool MIXED = true;
#else
const bool MIXED = HAS_PLACED != 0u;
#endif

// CPU drivers run the invocations of a dispatch one vector after the other, and wait for each node that is not in a
// cache. So the tiles of a region prefetch the nodes of the next region, line after line: a vector reads the eight
// lines of a cluster, each of its invocations one line.
void prefetch_nodes(uint region, uint place) {
    uvec2 turn = divided(place / 8u, BANDS);
    uint band = turn.y, parts = divided((1u << region_bits()) / 8u, BANDS).x, bin = band * REGIONS + region, sum = 0u;
    if (region >= REGIONS || turn.x >= parts) return;
    uint end = min(start_of_bin(bin + 1u), MAX_SPLATS / CLUSTER);
    for (uint i = start_of_bin(bin) + turn.x; i < end; i += parts) {
        sum |= four_of_nodes((i * CLUSTER + place % 8u * 2u) * NODE).x;
    }
    // Never true, but the compiler cannot know: without a use the reads would be removed.
    if (sum == END) atomicAdd(totals.disordered, 0u);
}

// Never reached. Without this bound a compiler assumes that the loop around the two reaches the list's end, and removes
// the check after it.
const uint MOST_TURNS = 0x7fffffffu;

const Row NOTHING = Row(vec4(0.0), vec4(0.0), vec4(0.0), vec4(1.0));

// Where a tile is, by its number.
uvec2 place_of_tile(uint tile) {
    return divided(tile, tiles_across()).yx;
}

// What its drops ask for.
void start_tile(uvec2 at, uint tile) {
    if (HAS_DEPTH != 0u) {
        vec4 upper = behind_of_row(tile, 0u), lower = behind_of_row(tile, 1u);
        upper_behind2 = upper * upper;
        lower_behind2 = lower * lower;
    }
    plane_corner = plane_of(vec2((at + first_tile()) * TILE));
    inverse_focal = 1.0 / frame.image.z;
    // A GPU keeps a word that is the same for all invocations once for all of them, but not a texel.
    if (GLINTS != 0u) first_source = FOR_GPU != 0u ? splat_table[TOWARD_SOURCES] : splat_of(TOWARD_SOURCES);
    upper_nearest = lower_nearest = NONE_MET;
}

// Draws its pixels, and sums up their logarithms.
void finish_tile(uint tile, Row upper, Row lower) {
    // From what is known in any case, so that a GPU keeps the place in no registers.
    uvec2 corner = uvec2(plane_corner + frame.principal.xy + 0.5) - frame.window.xy;
    float logs = finish(upper, upper_nearest, tile * PIXELS, corner)
        + finish(lower, lower_nearest, tile * PIXELS + TILE.x, corner + uvec2(0, 1));
    if (LOG_SUMS != 0u) log_sums[tile] = logs;
}
#endif
