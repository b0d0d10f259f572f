#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// The blocks, each a tile of a large drop: what the drop covers of its pixels, its colours there from
// the prefiltered pictures, and its entry into the tile's list; one invocation a block. See
// src/passes/tiles.rs.
#define PICTURE_TEXELS
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "appearance.glsl"
#include "projection.glsl"
#include "divided.glsl"
#include "rounded.glsl"
#include "behind.glsl"
#include "shared_exponent.glsl"
#include "shape_front.glsl"
#include "streak.glsl"
#include "together.glsl"

#include "spread_picture.glsl"

layout(local_size_x = 64) in;

// Radius in pixels from which a drop is never drawn as a box: across a long outline that leans it would be too far off.
const float BOX_PX = 1.5;

// Where a row of pixels is in a picture, in texels.
struct Places {
    vec4 x, y;
};

// Coverage of a row of a tile's pixels by a drop, whose centre is `from` before the first pixel's; and where
// in its picture of `edge` texels an edge the pixels are, from the middle of the first texel.
vec4 cover(vec2 from, vec4 to_disc, vec2 half_side, float radius, bool is_box, float edge, out Places places) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 s = to_disc.x * x + to_disc.z * from.y, t = to_disc.y * x + to_disc.w * from.y;
    // A pixel whose middle is outside covers, in the mean, what is a sixth of a pixel inside the rim.
    vec4 disc = sqrt(s * s + t * t), inwards = min(vec4(1.0), max(1.0 - 1.0 / (6.0 * radius), 0.5) / max(disc, 1e-3));
    places.x = clamp((0.5 * s * inwards + 0.5) * edge - 0.5, 0.0, edge - 1.0);
    places.y = clamp((0.5 * t * inwards + 0.5) * edge - 0.5, 0.0, edge - 1.0);

    // Part of the pixel's square that the drop covers. By its box of equal area: exactly, at every place. Else by a ramp of
    // one pixel across the edge, 1/(24 R) inside it, which keeps the disc's area.
    vec4 overlap = max(min(x + 0.5, half_side.x) - max(x - 0.5, -half_side.x), 0.0)
        * max(min(from.y + 0.5, half_side.y) - max(from.y - 0.5, -half_side.y), 0.0);
    vec4 slope_x = to_disc.x * s + to_disc.y * t, slope_y = to_disc.z * s + to_disc.w * t;
    vec4 edge_px = (1.0 - disc) * disc * inversesqrt(max(slope_x * slope_x + slope_y * slope_y, 1e-20));
    vec4 ramp = clamp(edge_px + 0.5 - 1.0 / (24.0 * radius), 0.0, 1.0);
    return is_box ? overlap : mix(ramp, vec4(1.0), lessThan(disc, vec4(1e-3)));
}

// Does what `cover` does, for a drop that is no sphere; `from`: its upper ellipse's centre.
vec4 cover_flat(vec2 from, vec4 to_disc, LargeShape l, bool is_box, float edge, out Places places) {
    vec2 half_side = box_of_equal_area(0.5 * (l.box.zw - l.box.xy), l.radius), middle = 0.5 * (l.box.xy + l.box.zw);
    vec4 upper = cover(from - (is_box ? middle : vec2(0.0)), to_disc, half_side, l.radius, is_box, edge, places);
    if (l.gradient == vec2(0.0)) return upper;
    Places of_lower;
    vec4 lower = cover(from - (is_box ? middle : l.lower), l.lower_to_disc, half_side, l.radius, is_box, edge, of_lower);
    vec4 parting = l.at_upper + l.gradient.x * (from.x + vec4(0.0, 1.0, 2.0, 3.0)) + l.gradient.y * from.y;
    places.x = mix(places.x, of_lower.x, greaterThan(parting, vec4(0.0)));
    places.y = mix(places.y, of_lower.y, greaterThan(parting, vec4(0.0)));
    return mix(upper, lower, greaterThan(parting, vec4(0.0)));
}

#include "moving_cover.glsl"
#include "disc.glsl"
#include "disc_cover.glsl"
#include "blurred_cover.glsl"

// Radius in pixels over which an outline is straight in a pixel, but for its bend: the areas of a disc have too few digits.
const float STRAIGHT_PX = 16.0;

// Does a disc cover a whole block? `from`: its first pixel's middle, from the disc's.
bool is_covered(vec2 from, vec4 to_disc) {
    vec2 middle = from + 0.5 * vec2(TILE) - 0.5, half_side = 0.5 * vec2(TILE);
    vec2 x = to_disc.xy * half_side.x, y = to_disc.zw * half_side.y, at = to_disc.xy * middle.x + to_disc.zw * middle.y;
    vec4 corners = vec4(dot(at + x + y, at + x + y), dot(at + x - y, at + x - y), dot(at - x + y, at - x + y), dot(at - x - y, at - x - y));
    return max(max(corners.x, corners.y), max(corners.z, corners.w)) < 1.0;
}

// Does what `cover` does for a drop whose colours are found by rays, without its error; `l`: of one that is no sphere.
vec4 cover_exactly(vec2 from, vec4 to_disc, float radius, bool is_flat, LargeShape l) {
    vec4 at_lower = vec4(0.0), covered;
    if (is_flat) at_lower = l.at_upper + l.gradient.x * (from.x + vec4(0.0, 1.0, 2.0, 3.0)) + l.gradient.y * from.y;
    if (radius > STRAIGHT_PX) {
        vec4 upper = cover_at(from, to_disc, radius);
        return is_flat ? mix(upper, cover_at(from - l.lower, l.lower_to_disc, radius), greaterThan(at_lower, vec4(0.0))) : upper;
    }
    for (uint i = 0u; i < TILE.x; ++i) {
        vec2 at = from + vec2(float(i), 0.0);
        covered[i] = at_lower[i] > 0.0 ? disc_cover(at - l.lower, l.lower_to_disc) : disc_cover(at, to_disc);
    }
    return covered;
}

// Does what `cover` does, for a drop that moves.
vec4 cover_moving(vec2 from, vec4 to_disc, vec2 half_side, float radius, float edge, vec2 way) {
    float length = length(way);
    Places places;
    if (radius < 1.0 && length > max(1.0, 1.5 * radius)) {
        // The squared half width of the outline's box at right angles to the way.
        vec2 n = vec2(-way.y, way.x) / length, box = half_side / 0.8862269;
        return streak_coverage(streak_of(vec2(0.0), way, 3.14159265 * radius * radius, dot(n * box, n * box), 0.0), from);
    }
    if (radius < 1.0) {
        vec2 wide = sqrt(half_side * half_side + 0.25 * way * way);
        return cover(from, to_disc, wide, radius, true, edge, places) * (half_side.x * half_side.y / (wide.x * wide.y));
    }
    if (length > STEPS_PX) return cover_by_columns(from, to_disc, way);
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < STEPS; ++i) {
        sum += cover_at(from - way * ((float(i) + 0.5) / float(STEPS) - 0.5), to_disc, radius);
    }
    return sum / float(STEPS);
}

// From when to when a drop that moves is over each pixel of a row and before what is behind, as parts of the exposure; in `shares`, what
// part that is of its time over the pixel. `first`: the middle of the row's first pixel.
void find_times(vec2 from, vec2 first, vec4 to_disc, vec2 moved, vec4 sphere, vec3 motion, vec4 behind, out vec2 times[4], out vec4 shares) {
    for (uint pixel = 0u; pixel < TILE.x; ++pixel) {
        vec2 p = vec2(from.x + float(pixel), from.y);
        times[pixel] = times_over(vec2(to_disc.x * p.x + to_disc.z * p.y, to_disc.y * p.x + to_disc.w * p.y), moved);
        float all = times[pixel].y - times[pixel].x;
        if (HAS_DEPTH != 0u) times[pixel] = times_before(times[pixel], sphere, motion, first + vec2(pixel, 0.0), behind[pixel]);
        shares[pixel] = all > 0.0 ? (times[pixel].y - times[pixel].x) / all : 1.0;
    }
}

// The colours of a row of pixels of a drop that moves: of each the mean of its picture along what moves over the pixel.
void write_moving_colors(uint at, uint picture, vec2 from, vec4 to_disc, float edge, vec2 moved, float way, vec2 times[4], vec3 turn,
                         Lightened l) {
    // Half a pixel more at each end, the pixel's own extent, as far as the drop is there.
    float length = length(moved), half_pixel = 0.5 * length / way;
    vec2 along = moved / length;
    for (uint pixel = 0u; pixel < TILE.x; ++pixel) {
        vec2 p = vec2(from.x + float(pixel), from.y);
        vec2 on_disc = vec2(to_disc.x * p.x + to_disc.z * p.y, to_disc.y * p.x + to_disc.w * p.y);
        float at_pixel = dot(on_disc, along);
        vec2 aside = on_disc - at_pixel * along;
        float rim = sqrt(max(1.0 - dot(aside, aside), 0.0));
        vec2 ends = clamp(at_pixel - length * times[pixel].yx + vec2(-half_pixel, half_pixel), -rim, rim);
        vec2 first = (0.5 * on_picture(aside + ends.x * along, turn) + 0.5) * edge;
        vec2 last = (0.5 * on_picture(aside + ends.y * along, turn) + 0.5) * edge;
        nodes[at + pixel] = pack_radiance(picture_along(picture, edge, first, last, turn, l));
    }
}

// The colour at a place in texels from the middle of the first.
uint color_at(uint picture, float edge, float steepness, vec2 at, vec3 turn, Lightened l) {
    vec2 on_disc = (at + 0.5) * (2.0 / edge) - 1.0;
    vec2 there = clamp((0.5 * on_picture(on_disc, turn) + 0.5) * edge - 0.5, 0.0, edge - 1.0);
    return pack_radiance(lightened(picture_light(picture, edge, steepness, there), l, on_disc));
}

// None where the drop covers nothing. (The choice comes last: without it LLVM packs colours lane by lane where they are stored.)
void write_colors(uint at, uint picture, float edge, float steepness, Places places, vec4 coverage, vec3 turn, Lightened l) {
    uvec4 colors;
    for (uint i = 0u; i < TILE.x; ++i) {
        colors[i] = coverage[i] > 0.0 ? color_at(picture, edge, steepness, vec2(places.x[i], places.y[i]), turn, l) : NO_COLOR;
    }
    write_four(at, colors);
}

// The colours of a row of pixels of a drop out of focus. That is a sphere: rays find what others show.
void write_blurred_colors(uint at, uint picture, vec2 from, vec4 to_disc, float edge, float blur, vec3 turn) {
    PictureBlur b = picture_blur(to_disc, edge, blur);
    for (uint pixel = 0u; pixel < TILE.x; ++pixel) {
        vec2 p = vec2(from.x + float(pixel), from.y);
        vec2 on_disc = vec2(to_disc.x * p.x + to_disc.z * p.y, to_disc.y * p.x + to_disc.w * p.y);
        nodes[at + pixel] = pack_radiance(picture_around(picture, edge, on_disc, b, turn));
    }
}

// Notes the blocks whose colours rays find, and asks for their workgroups of rays.comp: 256 invocations, eight for each block.
void note_ray_block(uint at, bool rays) {
    uvec4 here = subgroupBallot(rays);
    uint first = 0u, count = subgroupBallotBitCount(here), before = subgroupBallotExclusiveBitCount(here);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.ray_blocks, count, leads, first);
    if (count == 0u) return;
    if (leads) {
        uint end = first + count;
        for (uint piece = first / RAY_PIECE; piece * RAY_PIECE < end; ++piece) {
            uint in_piece = min(end - piece * RAY_PIECE, RAY_PIECE);
            atomicMax(totals.ray_groups[piece].x, (in_piece + 256u / PIXELS - 1u) / (256u / PIXELS));
        }
    }
    if (rays) blocks[MAX_BLOCKS + first + before] = at;
}

// What orders a drop at rest among drops that may intersect: its front's squared distance along the ray of the block's middle; of a ray
// beyond the rim, that of its point nearest to the drop's centre.
uint front_in_block(Large r, vec4 shape, vec2 middle) {
    vec3 d = normalize(ray_through(middle)), c = r.sphere.xyz, to_ray = cross(cross(d, c), d) / -r.sphere.w;
    float before = sqrt(max(1.0 - dot(to_ray, to_ray), 0.0));
    if (!is_round(shape)) {
        mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
        before = -front_of(shape, world * to_ray, world * d);
    }
    float front = max(dot(d, c) - before * r.sphere.w, 0.0);
    return floatBitsToUint(front * front);
}

// Fills a block's node; whether its colours are to be found by rays.
bool fill_block(uint at) {
    uint node = block_node(at);
    uint drop = large_of_block(at);
    Large r = large_at(drop);
    if ((r.look & AS_SPLATS) != 0u) return false;
    uint number = at - r.first_block;
    uvec2 at_tile = uvec2(r.first_tile & 0xffffu, r.first_tile >> 16)
        + divided(number, r.across).yx;
    bool rays = (r.look & BY_RAYS) != 0u;

    // `m` takes pixels to the unit disc: 1/√det is the radius of a disc of the outline's area, and the box holds its ellipse.
    vec4 m = r.to_disc;
    float det = abs(m.x * m.w - m.y * m.z), radius = inversesqrt(det);
    vec2 half_side = box_of_equal_area(vec2(length(m.wz), length(m.yx)) / det, radius);
    bool is_flat = SHAPE != SPHERES && (r.look & FLAT) != 0u;
    LargeShape l;
    if (is_flat) {
        l = large_shapes[drop];
        radius = l.radius;
        half_side = box_of_equal_area(0.5 * (l.box.zw - l.box.xy), radius);
    }
    Lightened light = not_flattened();
    if (is_flat) light = Lightened(l.lightened, l.upright);
    float fade = float(r.look >> 16) / 65535.0;
    // The outline's narrower axis: along it a pixel would miss finer texels, and a ramp would be wider than the drop.
    float squares = dot(m, m), most = 0.5 * (squares + sqrt(max(squares * squares - 4.0 * det * det, 0.0)));
    float narrow = radius * sqrt(det / most), edge = picture_edge(narrow);
    // A needle is no upright box; its cover is told exactly where rays find its light.
    bool is_long = rays && narrow < 1.0 && radius * radius > narrow;
    bool is_box = !is_long && (radius < 1.0 || (radius < BOX_PX && narrow < 1.0));
    uint picture = picture_word(r.look & 0xfffu, uint(edge));
    vec2 from = vec2(at_tile * TILE) + 0.5 - r.center;

    vec3 turn = rays ? vec3(0.0) : turn_of(r.sphere, r.look & 0xfffu);
    // What both rows are covered by. Later kinds replace earlier ones: by a ramp or a box, exactly, by two halves, moving, blurred, by rays.
    Places places_above, places_below;
    vec4 above = fade * cover(from, m, half_side, radius, is_box, edge, places_above);
    vec4 below = fade * cover(from + vec2(0.0, 1.0), m, half_side, radius, is_box, edge, places_below);
    // Exactly where pixels have so many rays that the ramp's error would show, and the outline crosses the block. (Everywhere the
    // pass took a third longer.) Loops, for CPU drivers run a branch that no lane takes, but no loop without turns.
    bool is_exact = is_long || MOST_RAYS > SAMPLES && rays && !is_box;
    uint exact_rows = is_exact && (is_flat || !is_covered(from, m)) ? TILE.y : 0u;
    for (uint row = 0u; row < exact_rows; ++row) {
        vec4 covered = fade * cover_exactly(from + vec2(0.0, row), m, radius, is_flat, l);
        if (row == 0u) above = covered; else below = covered;
    }
    if (is_flat && !is_exact) {
        above = fade * cover_flat(from, m, l, is_box, edge, places_above);
        below = fade * cover_flat(from + vec2(0.0, 1.0), m, l, is_box, edge, places_below);
    }
    bool moves_over = false, covered_by_rays = false, is_blurred = false;
    if (is_spread()) {
        vec2 way = moves[2u * drop + 1u].xy;
        covered_by_rays = (r.look & COVER_BY_RAYS) != 0u;
        moves_over = way != vec2(0.0) && !covered_by_rays;
        if (moves_over) {
            vec2 first = vec2(at_tile * TILE) + 0.5, moved = vec2(m.x * way.x + m.z * way.y, m.y * way.x + m.w * way.y);
            for (uint row = 0u; row < TILE.y; ++row) {
                vec2 down = vec2(0.0, row), times[4];
                vec4 behind = HAS_DEPTH != 0u ? behind_of_row(tile_number(at_tile), row) : vec4(0.0), shares;
                find_times(from + down, first + down, m, moved, r.sphere, moves[2u * drop].xyz, behind, times, shares);
                vec4 covered = fade * shares * cover_moving(from + down, m, half_side, radius, edge, way);
                if (row == 0u) above = covered; else below = covered;
                if (!rays) write_moving_colors(node + COLORS + row * TILE.x, picture, from + down, m, edge, moved, length(way), times, turn, light);
            }
        }
        float blur = moves[2u * drop + 1u].z;
        is_blurred = HAS_LENS != 0u && moves[2u * drop].w > 0.0 && !covered_by_rays;
        if (is_blurred) {
            vec2 first = vec2(at_tile * TILE);
            above = dithered(fade * blurred_cover(from, m, radius, blur), first, r.index);
            below = dithered(fade * blurred_cover(from + vec2(0.0, 1.0), m, radius, blur), first + vec2(0.0, 1.0), r.index);
            // Texels of a sixth to a third of what disc and pixel blur.
            float blurred_edge = exp2(clamp(ceil(log2(6.0 * radius * inversesqrt(blur * blur + 1.0 / 3.0))), 0.0, log2(edge)));
            uint coarser = picture_word(r.look & 0xfffu, uint(blurred_edge));
            if (!rays) {
                write_blurred_colors(node + COLORS, coarser, from, m, blurred_edge, blur, turn);
                write_blurred_colors(node + COLORS + TILE.x, coarser, from + vec2(0.0, 1.0), m, blurred_edge, blur, turn);
            }
        }
        if (covered_by_rays) above = below = vec4(1.0);
    }
    if (HAS_DEPTH != 0u && !moves_over && !covered_by_rays) {
        vec2 first = vec2(at_tile * TILE) + 0.5;
        uint behind = tile_number(at_tile);
        above *= row_before(r.sphere, first, behind_of_row(behind, 0u));
        below *= row_before(r.sphere, first + vec2(0.0, 1.0), behind_of_row(behind, 1u));
    }
    if (!rays && !moves_over && !is_blurred) {
        float steepness = picture_steepness(narrow, edge);
        write_colors(node + COLORS, picture, edge, steepness, places_above, above, turn, light);
        write_colors(node + COLORS + TILE.x, picture, edge, steepness, places_below, below, turn, light);
    }
    // Rays add what they find to nothing.
    float known = covered_by_rays ? 0.0 : 1.0;
    uvec4 shares = uvec4(pack_shares(known * above.xy), pack_shares(known * above.zw), pack_shares(known * below.xy),
                         pack_shares(known * below.zw));
    vec4 larger = max(above, below);
    float highest = max(max(larger.x, larger.y), max(larger.z, larger.w));
    // The choice comes last, as in `write_colors`.
    shares = highest > 0.0 ? shares : uvec4(0u);
    write_four(node + COVERAGE, shares);

    // The outline's box has corners that the outline does not reach.
    if (highest > 0.0) {
        bool by_front = (r.distance2 & PLACED_BIT) != 0u && !moves_over && !is_blurred && !covered_by_rays;
        uint before = r.distance2 & ~PLACED_BIT;
        for (uint once = 0u; once < uint(by_front); ++once) { // a loop instead of a branch, as above
            before = front_in_block(r, is_flat ? l.shape : ROUND, vec2(at_tile * TILE) + 0.5 * vec2(TILE));
        }
        uint next = atomicExchange(heads[tile_number(at_tile)], node + NEXT_OF_BLOCK);
        write_four(node, uvec4(before, r.index, 0u, next));
    }
    return highest > 0.0 && rays;
}

void main() {
    uint at = group_number() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    bool rays = false;
    if (at < min(totals.blocks, block_room())) rays = fill_block(at);
    note_ray_block(at, rays);
}
