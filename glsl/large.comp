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
#include "tile_buffers.glsl"
#include "splat.glsl"
#include "tile_drop.glsl"

layout(local_size_x = 64) in;

#define COUNTERS_BINDING 11
#include "counters.glsl"

// The first of `wanted` blocks for a subgroup, or of those that are left of `most`: what is given out is never more,
// so that no scene makes the count wrap.
uint take_blocks(uint wanted, uint most) {
    uint was = END, first = totals.blocks;
    while (first != was) {
        was = first;
        first = atomicCompSwap(totals.blocks, was, was + min(wanted, most - was));
    }
    uint groups = (first + min(wanted, most - first) + 63u) / 64u;
    atomicMax(totals.block_groups.x, min(groups, ROW));
    if (groups > ROW) atomicMax(totals.block_groups.y, (groups + ROW - 1u) / ROW);
    return first;
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

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= min(totals.larges, MAX_LARGES)) return;
    Large r;
    r.index = larges[at].index;
    Drop drop = drop_of(r.index);
    vec3 v = drop.view;
    float distance2;
    sighting(v, drop.radius, distance2);
    bool beside = is_beside(v, drop.radius);
    Outline o = outline_of(drop, distance2);
    r.sphere = vec4(v, drop.radius);
    r.center = o.center;
    float radius2 = drop.radius * drop.radius, flat2 = v.z * v.z - radius2;
    // Drops are ordered by their tangents' length: of two that do not touch, the one with the shorter is
    // never behind the other. By their centres a small drop behind a large one's rim would be before it. (A
    // splat's radius is nothing beside its distance.)
    r.distance2 = floatBitsToUint(distance2 - radius2);

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
    vec2 disc_r = vec2(dot(out_r, u), dot(out_r, w)), disc_t = vec2(dot(out_t, u), dot(out_t, w));
    bool rays = beside || o.radius > RAYS_PX || distance2 < NEAR_RADII * NEAR_RADII * radius2;
    if (rays) {
        disc_r = vec2(1.0, 0.0);
        disc_t = vec2(0.0, 1.0);
    }
    r.to_disc.xy = disc_r * (radial.x / axes.x) + disc_t * (across.x / axes.y);
    r.to_disc.zw = -(disc_r * (radial.y / axes.x) + disc_t * (across.y / axes.y));
    uint opacity = uint(opacity_at(distance2) * 65535.0 + 0.5);
    r.look = texel | (rays ? BY_RAYS : 0u) | opacity << 16;

    ivec4 pixels = pixels_in(o.center, o.box);
    if (beside) {
        // The outline is no ellipse: the rays of the pixels that may see it tell which do.
        r.center = pixel_of(vec2(0.0));
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
        vec2 x = seen_along(v.x, -v.z, drop.radius), y = seen_along(-v.y, -v.z, drop.radius);
        vec2 low = vec2(x.x, y.x), high = vec2(x.y, y.y);
        pixels = pixels_in(r.center + frame.image.z * 0.5 * (low + high), frame.image.z * 0.5 * (high - low));
    }
    uvec2 first = max(uvec2(pixels.xy) / TILE, first_tile()), end = min(uvec2(pixels.zw) / TILE + 1u, end_tile());
    bool nowhere = any(greaterThan(pixels.xy, pixels.zw)) || any(greaterThanEqual(first, end));
    uvec2 count = nowhere ? uvec2(0u) : end - first;

    vec2 half_sides = box_of_equal_area(o.box, o.radius);
    ivec4 of_splats = pixels_in(o.center, half_sides);
    uvec2 upper = uvec2(of_splats.xy) / TILE, lower = upper + uvec2(0, 2), last = uvec2(of_splats.zw) / TILE;
    bool splats = !beside && is_small(drop, o, half_sides, distance2) && all(lessThanEqual(last - upper, uvec2(1, 2)));
    if (splats) {
        count = uvec2(1u);
        r.look |= AS_SPLATS;
    }
    uint touched = count.x * count.y, most = block_room(), tiles = min(touched, most);
    r.first_tile = first.x | first.y << 16;
    r.across = count.x;

    uint block = 0u, before = subgroupExclusiveAdd(tiles), all_here = subgroupAdd(tiles);
    if (subgroupElect()) block = take_blocks(all_here, most);
    block = subgroupBroadcastFirst(block) + before;
    uint room = most - min(block, most);
    if (touched > room) atomicAdd(counters.lost, 1u);
    r.first_block = block;
    larges[at] = r;

    tiles = min(tiles, room);
    if (splats && tiles > 0u) {
        uint node = block_node(block);
        write_splat(node, distance2, r.index, o.center, half_sides, texel, upper);
        hang_splat(node, upper, last);
        node += NODE;
        write_splat(node, distance2, r.index, o.center, half_sides, texel, lower);
        hang_splat(node, lower, last);
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
