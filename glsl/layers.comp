#version 460
#extension GL_GOOGLE_include_directive : require
// For each pixel the nearest drop that covers a part of it, and how many do: depth, motion, number, count; one
// invocation a tile, after composite.comp. See src/passes/layers.rs.
#if defined(OF_CELLS) || defined(OF_CELLS_BY_TEXELS)
#define CELLS
#endif
#if defined(BY_TEXELS) || defined(OF_CELLS_BY_TEXELS)
#define TEXELS
#endif
#include "frame.glsl"
#include "rain.glsl"
#include "tile_buffers.glsl"
#include "splat.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "tile_drop.glsl"
#define REACH_BINDING 11
#include "reach.glsl"

layout(local_size_x = 64) in;

// A pixel each, row by row: planar depth as bits; motion in pixels, two halves; the drop's number, low and high word. Both
// are all 0 before.
layout(std430, set = 0, binding = 12) writeonly buffer Nearest { uvec4 nearest_out[]; };
// Drops that cover a part of the pixel.
layout(std430, set = 0, binding = 13) writeonly buffer Counts { uint counts_out[]; };
// Where camera and drops are at the end of the motion: `Motion` in src/passes/layers.rs.
layout(std430, set = 0, binding = 14) readonly buffer Motion {
    vec4 right;         // xyz: the camera's axes then, in world space
    vec4 up;
    vec4 back;
    vec4 shift;         // xyz: from the camera then to the camera now; w: focal length then, pixels
    vec4 principal;     // xy: where the view axis meets the picture then, pixels of the whole
    vec4 rain[MOST_POPULATIONS]; // xyz: how far the drops in boxes move
    vec4 classes[MOST_CLASSES];   // xyz: how far those of each class of real rain move
    vec4 placed_drops[]; // xyz: how far each placed drop moves
} motion;

#define NODES_BINDING 15
#include "nodes_by_four.glsl"

const float FARTHEST_MOTION = 65504.0; // a half's largest

// Squared distance and number of the nearest drop so far, pixel by pixel of a row, and how many there are.
struct Row {
    uvec4 distance2, index, count;
};

void take(inout Row row, bvec4 covered, uint distance2, uint index) {
    row.count += uvec4(covered);
    bvec4 nearer = lessThan(uvec4(distance2), row.distance2);
    bvec4 as_near = equal(uvec4(distance2), row.distance2), before = lessThan(uvec4(index), row.index);
    bvec4 first = bvec4(uvec4(covered) & (uvec4(nearer) | uvec4(as_near) & uvec4(before)));
    row.distance2 = mix(row.distance2, uvec4(distance2), first);
    row.index = mix(row.index, uvec4(index), first);
}

// Which pixels of a row of a block have a part of the drop: it is covered, and has a colour.
bvec4 covered_by_block(uvec2 coverage, uvec4 colors) {
    uvec4 parts = uvec4(coverage.x & 0xffffu, coverage.x >> 16, coverage.y & 0xffffu, coverage.y >> 16);
    return bvec4(uvec4(notEqual(parts, uvec4(0u))) & uvec4(notEqual(colors, uvec4(NO_COLOR))));
}

uvec2 number_of(uint index) {
#ifdef CELLS
    if (is_by_hand(index)) return uvec2(by_hand_number(index) + 1u, 0u);
    Slab slab = field.slabs[field.group_slabs[min(index / (64u * CELLS_GROUP), field.groups.x - 1u)]];
    ivec3 from_camera = cell_of(slab, index / 64u - slab.first_group * CELLS_GROUP);
    // `drop_number` in src/rain/field.rs: seventeen bits of the cell's number along each axis.
    uvec3 cell = (field.classes[slab.kind].cell_low.xyz + uvec3(from_camera)) & 0x1ffffu;
    return uvec2(index % 64u + 1u | cell.x << 7 | cell.y << 24, cell.y >> 8 | cell.z << 9 | slab.kind + 1u << 26);
#else
    return uvec2(index + 1u, 0u);
#endif
}

vec3 moved_by(uint index) {
    if (is_by_hand(index)) return motion.placed_drops[by_hand_number(index)].xyz;
#ifdef CELLS
    return motion.classes[field.slabs[field.group_slabs[min(index / (64u * CELLS_GROUP), field.groups.x - 1u)]].kind].xyz;
#else
    return motion.rain[population_number(index)].xyz;
#endif
}

// Depth, motion and number of a drop, as a pixel has them.
uvec4 told_of(uint index) {
    Drop drop = drop_of(index);
    vec3 now = drop.view, from = drop.relative + moved_by(index) + motion.shift.xyz;
    vec3 then = vec3(dot(motion.right.xyz, from), dot(motion.up.xyz, from), dot(motion.back.xyz, from));
    vec2 here = frame.principal.xy + vec2(now.x, -now.y) * (frame.image.z / -now.z);
    vec2 there = motion.principal.xy + vec2(then.x, -then.y) * (motion.shift.w / -then.z);
    // A drop whose centre is beside or behind the camera has no place in the picture.
    vec2 moves = now.z < 0.0 && then.z < 0.0 ? clamp(there - here, -FARTHEST_MOTION, FARTHEST_MOTION) : vec2(0.0);
    return uvec4(floatBitsToUint(-now.z), packHalf2x16(moves), number_of(index));
}

void write_pixel(uint at, uint count, uvec4 told) {
    counts_out[at] = count;
    nearest_out[at] = told;
}

// What is told of a row's pixels, pixel by pixel of each word.
struct Told {
    uvec4 depth, motion, low, high;
};
const Told NOTHING = Told(uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u));

void tell(inout Told row, uvec4 nearest, uint index, uvec4 told) {
    bvec4 its = equal(nearest, uvec4(index));
    row.depth = mix(row.depth, uvec4(told.x), its);
    row.motion = mix(row.motion, uvec4(told.y), its);
    row.low = mix(row.low, uvec4(told.z), its);
    row.high = mix(row.high, uvec4(told.w), its);
}

void write_row(uvec4 count, Told row, uvec2 first) {
    uvec2 size = frame.window.zw;
    uint at = first.y * size.x + first.x;
    bvec4 drawn = lessThan(first.x + uvec4(0, 1, 2, 3), uvec4(first.y < size.y ? size.x : 0u));
    drawn = bvec4(uvec4(drawn) & uvec4(notEqual(count, uvec4(0u))));
    if (drawn.x) write_pixel(at, count.x, uvec4(row.depth.x, row.motion.x, row.low.x, row.high.x));
    if (drawn.y) write_pixel(at + 1u, count.y, uvec4(row.depth.y, row.motion.y, row.low.y, row.high.y));
    if (drawn.z) write_pixel(at + 2u, count.z, uvec4(row.depth.z, row.motion.z, row.low.z, row.high.z));
    if (drawn.w) write_pixel(at + 3u, count.w, uvec4(row.depth.w, row.motion.w, row.low.w, row.high.w));
}

// The least of numbers that are not told of yet: all below `from` are.
uint next_from(uvec4 upper, uvec4 lower, uint from) {
    uvec4 least = min(mix(upper, uvec4(END), lessThan(upper, uvec4(from))), mix(lower, uvec4(END), lessThan(lower, uvec4(from))));
    return min(min(least.x, least.y), min(least.z, least.w));
}

void main() {
    uint tile = group_number() * 64u + gl_LocalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uvec2 at = uvec2(tile % tiles_across(), tile / tiles_across());
    vec4 upper_reach2 = vec4(0.0), lower_reach2 = vec4(0.0);
    if (HAS_DEPTH != 0u) {
        vec4 upper_reach = reach_of_row(tile, 0u), lower_reach = reach_of_row(tile, 1u);
        upper_reach2 = upper_reach * upper_reach;
        lower_reach2 = lower_reach * lower_reach;
    }
    Row upper = Row(uvec4(END), uvec4(END), uvec4(0u)), lower = upper;
    uint link = heads[tile];
    while (link != END) {
        uint node = node_of(link);
        uvec4 words = four_of_nodes(node);
        bvec4 above, below;
        if (is_block(link)) {
            uvec4 coverage = four_of_nodes(node + COVERAGE);
            above = covered_by_block(coverage.xy, four_of_nodes(node + COLORS));
            below = covered_by_block(coverage.zw, four_of_nodes(node + COLORS + TILE.x));
        } else {
            // As composite.comp covers pixels with it.
            uint which = link & 3u;
            vec2 half_sides = unpack_half_sides(words.w);
            vec2 from = vec2(uvec2(which & 1u, which >> 1) * TILE) - splat_center(words.z);
            vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
            bvec4 columns = lessThan(clamp(-half_sides.x - x, 0.0, 1.0), clamp(half_sides.x - x, 0.0, 1.0));
            vec2 y = from.y + vec2(0.0, 1.0);
            bvec2 rows = lessThan(clamp(-half_sides.y - y, 0.0, 1.0), clamp(half_sides.y - y, 0.0, 1.0));
            above = bvec4(uvec4(columns) & uint(rows.x));
            below = bvec4(uvec4(columns) & uint(rows.y));
            if (HAS_DEPTH != 0u) {
                vec4 distance2 = vec4(uintBitsToFloat(words.x));
                above = bvec4(uvec4(above) & uvec4(greaterThan(upper_reach2, distance2)));
                below = bvec4(uvec4(below) & uvec4(greaterThan(lower_reach2, distance2)));
            }
        }
        take(upper, above, words.x, words.y);
        take(lower, below, words.x, words.y);
        link = one_of_nodes(link);
    }
    uvec2 corner = (at + first_tile()) * TILE - frame.window.xy;
    // A drop is told of once, whatever it has of the tile's pixels.
    Told above = NOTHING, below = NOTHING;
    uint index = next_from(upper.index, lower.index, 0u);
    while (index != END) {
        uvec4 told = told_of(index);
        tell(above, upper.index, index, told);
        tell(below, lower.index, index, told);
        index = next_from(upper.index, lower.index, index + 1u);
    }
    write_row(upper.count, above, corner);
    write_row(lower.count, below, corner + uvec2(0, 1));
}
