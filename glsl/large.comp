#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// The drops of more than a splat: outline, direction, opacity, and a block for each tile that the
// outline's box meets; or two splats, if it is as small as one but meets three rows of tiles. One invocation a
// drop. See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "octahedron.glsl"
#define LARGES_ACCESS writeonly
#include "tile_buffers.glsl"
#include "bigs.glsl"
#include "splat.glsl"
#include "tile_drop.glsl"
#include "lens.glsl"
#include "motion.glsl"
#include "shape.glsl"
#include "shape_given.glsl"
#include "drop_records.glsl"

layout(local_size_x = 64) in;

// A disc that is larger than its drop by so much covers a quarter of a unit of coverage (1/65535).
const float UNSEEN_RADII = 512.0;

#include "together.glsl"

// Asks for workgroups that fill so many blocks, as far as there are `most`.
void ask_for_groups(uint blocks, uint most) {
    uint groups = (min(blocks, most) + 63u) / 64u;
    atomicMax(totals.block_groups.x, min(groups, ROW));
    if (groups > ROW) atomicMax(totals.block_groups.y, (groups + ROW - 1u) / ROW);
}

// Where a sphere beside the camera is seen along one axis of the screen, in focal lengths from the middle: its
// shadow on the plane of that axis and the view's is a disc, of which the camera sees what one tangent
// leaves; with the camera inside, all. The tangent's slope in the form that loses no digits.
vec2 seen_along(float across, float depth, float radius) {
    const float NOWHERE = 1e4;
    float off = abs(across), tangent2 = off * off + depth * depth - radius * radius;
    float tangent = radius * sqrt(max(tangent2, 0.0));
    float low = depth > 0.0
        ? (off - radius) * (off + radius) / (tangent + off * depth)
        : (tangent - off * depth) / max(radius * radius - depth * depth, 1e-6 * radius * radius);
    // A little more, for rounding.
    low -= 0.01 * (1.0 + low * low);
    if (tangent2 <= 0.0) low = -NOWHERE;
    return across > 0.0 ? vec2(low, NOWHERE) : vec2(-NOWHERE, -low);
}

// The same of one that moves between two places, each across and depth: all, where it comes over the camera or its plane.
vec2 passes_along(vec2 from, vec2 to, float radius) {
    const float NOWHERE = 1e4;
    vec2 a = seen_along(from.x, from.y, radius), b = seen_along(to.x, to.y, radius), way = to - from;
    vec2 nearest = from + way * clamp(-dot(from, way) / max(dot(way, way), 1e-30), 0.0, 1.0);
    bool over = dot(nearest, nearest) <= radius * radius || from != to && from.y * to.y <= 0.0;
    return over ? vec2(-NOWHERE, NOWHERE) : vec2(min(a.x, b.x), max(a.y, b.y));
}

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= min(totals.larges, MAX_LARGES)) return;
    Large r;
    r.index = larges[at].index;
    Drop drop = drop_of(r.index);
    vec3 v = drop.view;
    float distance2;
    sighting(v, drop.radius, distance2);
    vec4 shape = shape_of(r.index, drop);
    bool flat_drop = !is_round(shape);
    float reach = drop.radius * reach_of_shape(shape);
    bool exposed = is_exposed(), beside = is_beside(v, flat_drop ? depth_of_shape(drop.radius, shape) : drop.radius);
    Path path = path_at_rest();
    if (exposed) path = path_of(v, reach, motion_of(r.index));
    Outline o = outline_of(drop, distance2);
    ShapeOutline s;
    if (flat_drop && !beside) {
        vec4 seen = seen_as(shape, path);
        s = shape_outline_of(v, drop.radius, seen);
        o = outline_of_shape(drop, seen);
    }
    r.sphere = vec4(v, drop.radius);
    vec2 half_sides = box_of_equal_area(o.box, o.radius);
    float splat_opacity = 1.0, blur = blur_of(v, path.moved, drop.radius), disc = blur > 0.0 ? disc_of(-v.z) : 0.0;
    if (exposed) {
        half_sides = blurred(half_sides, path, splat_opacity);
        o.center += path.aside;
    }
    if (is_spread()) {
        moves[2u * at] = vec4(path.moved, blur);
        moves[2u * at + 1u] = vec4(path.way, disc, 0.0);
    }
    if (is_lens() && blur > 0.0) half_sides = defocused(half_sides, disc, splat_opacity);
    r.center = o.center;
    float radius2 = drop.radius * drop.radius, flat2 = v.z * v.z - radius2;
    // Drops are ordered by their tangents' length: of two that do not touch, the one with the shorter is
    // never behind the other. By their centres a small drop behind a large one's rim would be before it. (A
    // splat's radius is nothing beside its distance.)
    r.distance2 = floatBitsToUint(flat_drop ? max(distance2 - radius2, 0.0) : distance2 - radius2);

    // Its picture: that of the nearest direction, turned as that direction's basis is. `radial` and
    // `across` are the outline's axes on the screen, `out_r` and `out_t` how they leave the ray.
    float far = length(v.xy), distance_r = inversesqrt(distance2);
    vec2 radial = far > 0.0 ? v.xy / far : vec2(1.0, 0.0), across = vec2(-radial.y, radial.x);
    vec2 axes = frame.image.z * drop.radius * vec2(sqrt(distance2 - radius2) / flat2, inversesqrt(flat2));
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    uint texel = direction_texel(drop.relative * distance_r);
    vec3 n = texel_direction(texel), u, w;
    basis(n, u, w);
    vec3 out_r = world * vec3(radial * (-v.z * distance_r), far * distance_r);
    vec3 out_t = world * vec3(across, 0.0);
    // A rotation, though that direction is off by up to 2°: else the outline's area were up to 1e-3 off.
    vec2 disc_r = normalize(vec2(dot(out_r, u), dot(out_r, w))), disc_t = vec2(-disc_r.y, disc_r.x);
    disc_t *= sign(dot(disc_t, vec2(dot(out_t, u), dot(out_t, w))));
    float rays_px = flat_drop ? FLAT_RAYS_PX : RAYS_PX;
    bool rays = beside || !path.even || o.radius > rays_px || distance2 < NEAR_RADII * NEAR_RADII * radius2;
    // What moves and is spread over a disc as well has no closed form, nor has what is no sphere.
    rays = rays || is_lens() && blur > 0.0 && (path.moved != vec3(0.0) || flat_drop);
    if (rays) {
        disc_r = vec2(1.0, 0.0);
        disc_t = vec2(0.0, 1.0);
    }
    r.to_disc.xy = disc_r * (radial.x / axes.x) + disc_t * (across.x / axes.y);
    r.to_disc.zw = -(disc_r * (radial.y / axes.x) + disc_t * (across.y / axes.y));
    if (flat_drop && beside) {
        large_shapes[at] = no_outline(shape);
    } else if (flat_drop) {
        mat2 turned = mat2(1.0);
        if (!rays) {
            turned = flattening(shape, drop.relative * distance_r, u, w) * mat2(r.to_disc.xy, r.to_disc.zw);
        }
        mat2 upper = to_disc_of(s.upper, turned), lower = to_disc_of(s.lower, turned);
        r.to_disc = vec4(upper[0], upper[1]);
        r.center = s.upper.center + path.aside;
        LargeShape l;
        l.shape = shape;
        l.lower_to_disc = vec4(lower[0], lower[1]);
        l.lower = s.lower.center - s.upper.center;
        l.gradient = s.gradient;
        l.box = box_of(s);
        l.at_upper = s.at_upper;
        l.radius = o.radius;
        l.unused = vec2(0.0);
        large_shapes[at] = l;
    }
    uint opacity = uint(opacity_at(distance2) * 65535.0 + 0.5);
    r.look = texel | (rays ? BY_RAYS : 0u) | (flat_drop ? FLAT : 0u) | opacity << 16;

    // A thin streak is spread over as much as a pixel beyond its outline (streak.glsl).
    float beyond_outline = path.way != vec2(0.0) && o.radius < 1.0 ? 1.0 : 0.0;
    ivec4 pixels = pixels_in(o.center, o.box + reach_of(path) + min(disc, MOST_BLUR_PX) + beyond_outline);
    // A far sphere at rest is covered as its outline and the disc overlap, the others as their rays find.
    bool is_near = beside || distance2 < NEAR_RADII * NEAR_RADII * radius2;
    bool through_lens = is_lens() && blur > 0.0 && (is_near || path.moved != vec3(0.0) || flat_drop);
    if (!path.even || through_lens) r.look |= COVER_BY_RAYS;
    if (through_lens && blur == MOST_BLUR_PX) {
        // It comes to the lens: it may be anywhere.
        pixels = ivec4(ivec2(0), ivec2(frame.image.xy) - 1);
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
    } else if (through_lens) {
        vec3 from = v - 0.5 * path.moved, to = v + 0.5 * path.moved;
        vec2 xa = seen_through_lens(from.x, -from.z, reach), xb = seen_through_lens(to.x, -to.z, reach);
        vec2 ya = seen_through_lens(-from.y, -from.z, reach), yb = seen_through_lens(-to.y, -to.z, reach);
        vec2 low = vec2(min(xa.x, xb.x), min(ya.x, yb.x)), high = vec2(max(xa.y, xb.y), max(ya.y, yb.y));
        vec2 most = vec2(MOST_BLUR_PX);
        low = clamp(frame.image.z * low, -most, most);
        high = clamp(frame.image.z * high, -most, most);
        pixels = pixels_in(pixel_of(0.5 * (low + high)), 0.5 * (high - low));
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
    } else
    if (!path.even && !path.near) {
        // Around the outlines at both ends.
        vec3 ends[2] = vec3[2](v - 0.5 * path.moved, v + 0.5 * path.moved);
        Outline a = outline_of(Drop(vec3(0.0), ends[0], reach), dot(ends[0], ends[0]));
        Outline b = outline_of(Drop(vec3(0.0), ends[1], reach), dot(ends[1], ends[1]));
        vec2 low = min(a.center - a.box, b.center - b.box), high = max(a.center + a.box, b.center + b.box);
        pixels = pixels_in(0.5 * (low + high), 0.5 * (high - low));
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
    } else if (beside || path.near) {
        // The outline is no ellipse: the rays of the pixels that may see it tell which do.
        r.center = pixel_of(vec2(0.0));
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
        vec3 from = v - 0.5 * path.moved, to = v + 0.5 * path.moved;
        vec2 x = passes_along(vec2(from.x, -from.z), vec2(to.x, -to.z), reach);
        vec2 y = passes_along(vec2(-from.y, -from.z), vec2(-to.y, -to.z), reach);
        vec2 low = vec2(x.x, y.x), high = vec2(x.y, y.y);
        pixels = pixels_in(r.center + frame.image.z * 0.5 * (low + high), frame.image.z * 0.5 * (high - low));
    }
    uvec2 first = max(uvec2(pixels.xy) / TILE, first_tile()), end = min(uvec2(pixels.zw) / TILE + 1u, end_tile());
    bool nowhere = any(greaterThan(pixels.xy, pixels.zw)) || any(greaterThanEqual(first, end));
    // Spread so wide that it covers less than a unit of coverage anywhere: it would take fragments all over the picture.
    nowhere = nowhere || is_lens() && !beside && disc > UNSEEN_RADII * o.radius;
    uvec2 count = nowhere ? uvec2(0u) : end - first;

    ivec4 of_splats = pixels_in(o.center, half_sides);
    uvec2 upper = uvec2(of_splats.xy) / TILE, lower = upper + uvec2(0, 2), last = uvec2(of_splats.zw) / TILE;
    bool splats = !beside && path.even && is_small(drop, o, half_sides, distance2) && is_short(o, path)
        && is_little(o.radius, disc) && all(lessThanEqual(last - upper, uvec2(1, 2)));
    if (splats) {
        count = uvec2(1u);
        r.look |= AS_SPLATS;
    }
    uint touched = count.x * count.y, most = block_room(), tiles = min(touched, most);
    r.first_tile = first.x | first.y << 16;
    r.across = count.x;

    // Once there is no room nobody asks for more, so that the count does not wrap.
    bool has_room = totals.blocks < most;
    uint block = most, before = subgroupExclusiveAdd(tiles), all_here = subgroupAdd(tiles), asked = uint(has_room) * all_here;
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.blocks, asked, leads, block);
    if (leads && asked > 0u) ask_for_groups(block + asked, most);
    block += before;
    uint room = most - min(block, most);
    if (touched > room) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
    }
    r.first_block = block;
    larges[at] = r;
#ifdef CELLS
    // From here on the number tells drops apart, for what is left to chance. A cell's place among those in view is another
    // in each part of a picture, a drop's radius and its number in the cell are not.
    if (!is_by_hand(r.index)) larges[at].index = floatBitsToUint(drop.radius) * 64u + r.index % 64u;
#endif
    uvec4 record = NEAREST != 0u ? record_of(r.index, drop) : uvec4(0u);
    if (NEAREST != 0u) drop_records[large_record(at)] = record;

    tiles = min(tiles, room);
    if (splats && tiles > 0u) {
        uint node = block_node(block);
        write_splat(node, distance2, r.index, o.center, half_sides, splat_opacity, texel, upper);
        hang_splat(node, upper, last);
        if (NEAREST != 0u) drop_records[node / NODE] = record;
        node += NODE;
        write_splat(node, distance2, r.index, o.center, half_sides, splat_opacity, texel, lower);
        hang_splat(node, lower, last);
        if (NEAREST != 0u) drop_records[node / NODE] = record;
    }
    bool big = tiles > MOST_TILES;
    uint few = big ? 0u : tiles;
    for (uint i = 0u; i < few; ++i) blocks[block + i] = at;
    if (big) {
        uint place = atomicAdd(totals.bigs, 1u);
        bigs[place] = uvec2(at, tiles);
        atomicMax(totals.big_groups.x, min(place + 1u, MOST_BIG_GROUPS));
    }
}
