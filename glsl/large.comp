#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// The drops of more than a splat: outline, direction, opacity, and a block for each tile that the
// outline's box meets; or two splats, if it is as small as one but meets three rows of tiles. One invocation a
// drop. See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#define LARGES_ACCESS writeonly
#include "tile_buffers.glsl"
#include "shown_from.glsl"
#include "bigs.glsl"
#include "splat.glsl"
#include "tile_drop.glsl"
#include "lens.glsl"
#include "motion.glsl"
#include "shape.glsl"
#include "shape_given.glsl"
#include "drop_records.glsl"
#include "flattened.glsl"
#include "picture_halves.glsl"

layout(std430, set = 1, binding = 12) readonly buffer FlatLight { uvec4 flat_light[]; };

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

// Where a sphere beside the camera is seen along one axis of the screen, in focal lengths from the middle: from its tangent on, or
// everywhere, where the camera is within its shadow on the plane of that axis and the view's. No digits of the tangent's slope cancel.
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

// Where a sphere is seen that moves between two places, each across and depth: everywhere, where it comes over the camera or its plane.
vec2 passes_along(vec2 from, vec2 to, float radius) {
    const float NOWHERE = 1e4;
    vec2 a = seen_along(from.x, from.y, radius), b = seen_along(to.x, to.y, radius), way = to - from;
    vec2 nearest = from + way * clamp(-dot(from, way) / max(dot(way, way), 1e-30), 0.0, 1.0);
    bool over = dot(nearest, nearest) <= radius * radius || from != to && from.y * to.y <= 0.0;
    return over ? vec2(-NOWHERE, NOWHERE) : vec2(min(a.x, b.x), max(a.y, b.y));
}

// Where a large drop is, how it is spread, and its outline, as it is at the middle of its way.
struct Found {
    Drop drop;
    float distance2, radius2;
    vec4 shape;
    bool is_flat, is_beside;
    float reach; // radius of a sphere that holds it
    Path path;
    Outline outline;
    ShapeOutline halves; // of a drop that is FLAT
    vec2 half_sides;     // of its box as a splat
    float opacity;       // of that, for how it is spread
    float blur, disc;    // pixels: the largest disc that a lens makes of a point of it, and that of its middle
};

Found find(uint index) {
    Found f;
    f.drop = drop_of(index);
    vec3 v = f.drop.view;
    visibility(v, f.drop.radius, f.distance2);
    f.radius2 = f.drop.radius * f.drop.radius;
    f.shape = shape_of(index, f.drop);
    f.is_flat = !is_round(f.shape);
    f.reach = f.drop.radius * reach_of_shape(f.shape);
    f.is_beside = is_beside(v, f.is_flat ? depth_of_shape(f.drop.radius, f.shape) : f.drop.radius);
    f.path = path_at_rest();
    if (is_exposed()) f.path = path_of(v, f.reach, motion_of(index));
    f.outline = outline_of(f.drop, f.distance2);
    if (f.is_flat && !f.is_beside) {
        vec4 seen = seen_as(f.shape, f.path);
        f.halves = shape_outline_of(v, f.drop.radius, seen);
        f.outline = outline_of_shape(f.drop, seen);
    }
    f.half_sides = box_of_equal_area(f.outline.box, f.outline.radius);
    f.opacity = 1.0;
    f.blur = blur_of(v, f.path.moved, f.drop.radius);
    f.disc = f.blur > 0.0 ? disc_of(-v.z) : 0.0;
    if (is_exposed()) {
        f.half_sides = blurred(f.half_sides, f.path, f.opacity);
        f.outline.center += f.path.aside;
    }
    if (is_lens() && f.blur > 0.0) f.half_sides = defocused(f.half_sides, f.disc, f.opacity);
    return f;
}

// Radii in pixels from which on drops that are spread are drawn by rays at the earliest: spheres, and others that are traced.
const float SPREAD_RAYS_PX = 12.0, FLAT_SPREAD_RAYS_PX = 4.0;

// Whether a drop's colours are found by rays. What moves and is spread over a disc as well has no closed form, nor has what is
// no sphere.
bool is_by_rays(Found f) {
    float rays_px = f.is_flat ? FLAT_RAYS_PX : RAYS_PX;
    // A small drop that is spread has less noise by its picture.
    bool is_spread_out = f.path.moved != vec3(0.0) || f.blur > 0.0;
    if (rays_px > 0.0 && is_spread_out) rays_px = max(rays_px, f.is_flat && SHAPE >= TRACED ? FLAT_SPREAD_RAYS_PX : SPREAD_RAYS_PX);
    bool rays = f.is_beside || !f.path.even || f.outline.radius > rays_px
        || f.distance2 < NEAR_RADII * NEAR_RADII * f.radius2;
    return rays || is_lens() && f.blur > 0.0 && (f.path.moved != vec3(0.0) || f.is_flat);
}

// Parts of a shape's outline that its upper and its lower half have: each as much as it is high. `cosine2`: squared, of the
// elevation from which it is seen.
vec2 halves_of(vec4 shape, float cosine2) {
    vec2 high = sqrt(shape.yz * shape.yz * cosine2 + shape.x * shape.x * (1.0 - cosine2));
    return high / (high.x + high.y);
}

// How the picture of a direction is made as light as a drop of a shape; not, where the table has nothing. `upright`: in the
// picture; `seen`: the shape whose outline has the picture; `radius`: in pixels.
uvec4 lightened_as(vec4 shape, vec4 seen, uint texel, vec2 upright, float radius) {
    vec3 mean = unpack_radiance(pictures[picture_word(texel, 1u)]), sphere[2], drop[2];
    uvec4 means = flat_light[2u * texel], lower_means = flat_light[2u * texel + 1u];
    picture_halves(texel, -upright, sphere[0], sphere[1]);
    if (means.x == NO_PICTURE) return pack_lightened(sphere, sphere);
    float cosine2 = min(dot(upright, upright), 1.0), flatness = flatness_of_shape(shape);
    vec2 own = halves_of(shape, cosine2), drawn = radius < 1.0 ? vec2(0.5) : halves_of(seen, cosine2);
    vec3 of_drop = light_of_flatness(mean, means, flatness);
    drop[1] = light_of_flatness(sphere[1], lower_means, flatness);
    drop[0] = max(of_drop - own.y * drop[1], 0.0) / own.x;
    // The halves of a box, and of what moves, are drawn as large as each other.
    vec3 whole = of_drop / max(drawn.x * drop[0] + drawn.y * drop[1], 1e-30);
    for (uint i = 0u; i < 2u; ++i) drop[i] *= whole;
    // Pixels mix the picture's halves; by so much that drops of 0.8 to 2.3 pixels have their rays' light within 5 %.
    float apart = max(1.0 - 0.25 / radius, 0.0);
    for (uint i = 0u; i < 2u; ++i) sphere[i] = mix(mean, sphere[i], apart);
    return pack_lightened(sphere, drop);
}

// Where on its picture a drop's pixels are: the picture of the nearest direction, turned as that direction's basis is, or
// upright for rays. Writes what a flat drop has besides, and returns the direction's number.
uint orient(inout Large r, Found f, uint at, bool rays) {
    vec3 v = f.drop.view;
    float flat2 = v.z * v.z - f.radius2;
    // `radial` and `across` are the outline's axes on the screen, `out_r` and `out_t` how they leave the ray.
    float far = length(v.xy), distance_r = inversesqrt(f.distance2);
    vec2 radial = far > 0.0 ? v.xy / far : vec2(1.0, 0.0), across = vec2(-radial.y, radial.x);
    vec2 axes = frame.image.z * f.drop.radius * vec2(sqrt(f.distance2 - f.radius2) / flat2, inversesqrt(flat2));
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    uint texel = shown_from(f.drop.relative * distance_r, v);
    vec3 n = texel_direction(texel), u, w;
    basis(n, u, w);
    vec3 out_r = world * vec3(radial * (-v.z * distance_r), far * distance_r);
    vec3 out_t = world * vec3(across, 0.0);
    // This is a rotation, although the direction is off by up to 3.8°: by a projection the outline's area would be up to 2e-3 too small.
    vec2 disc_r = normalize(vec2(dot(out_r, u), dot(out_r, w))), disc_t = vec2(-disc_r.y, disc_r.x);
    disc_t *= sign(dot(disc_t, vec2(dot(out_t, u), dot(out_t, w))));
    if (rays) {
        disc_r = vec2(1.0, 0.0);
        disc_t = vec2(0.0, 1.0);
    }
    r.to_disc.xy = disc_r * (radial.x / axes.x) + disc_t * (across.x / axes.y);
    r.to_disc.zw = -(disc_r * (radial.y / axes.x) + disc_t * (across.y / axes.y));
    if (f.is_flat && f.is_beside) {
        large_shapes[at] = no_outline(f.shape);
    } else if (f.is_flat) {
        mat2 turned = mat2(1.0);
        if (!rays) turned = flattening(f.shape, f.drop.relative * distance_r, u, w) * mat2(r.to_disc.xy, r.to_disc.zw);
        mat2 upper = to_disc_of(f.halves.upper, turned), lower = to_disc_of(f.halves.lower, turned);
        r.to_disc = vec4(upper[0], upper[1]);
        r.center = f.halves.upper.center + f.path.aside;
        large_shapes[at] = LargeShape(f.shape, vec4(lower[0], lower[1]), f.halves.lower.center - f.halves.upper.center,
                                      f.halves.gradient, box_of(f.halves), f.halves.at_upper, f.outline.radius,
                                      packSnorm2x16(normalize(vec2(u.y, w.y) + 1e-6)), 0u, uvec4(0u));
        if (!rays) {
            vec4 seen = seen_as(f.shape, f.path);
            large_shapes[at].lightened = lightened_as(f.shape, seen, texel, vec2(u.y, w.y), f.outline.radius);
        }
    }
    return texel;
}

// First and last pixel of what may show a drop. Marks drops whose rays find what they cover.
ivec4 pixels_of(inout Large r, Found f) {
    vec3 v = f.drop.view;
    // A thin streak is spread over as much as a pixel beyond its outline (streak.glsl).
    float beyond_outline = f.path.way != vec2(0.0) && f.outline.radius < 1.0 ? 1.0 : 0.0;
    vec2 box = f.outline.box + reach_of(f.path) + min(f.disc, MOST_BLUR_PX) + beyond_outline;
    ivec4 pixels = pixels_in(f.outline.center, box);
    // A far sphere at rest is covered as its outline and the disc overlap, the others as their rays find.
    bool is_near = f.is_beside || f.distance2 < NEAR_RADII * NEAR_RADII * f.radius2;
    bool through_lens = is_lens() && f.blur > 0.0 && (is_near || f.path.moved != vec3(0.0) || f.is_flat);
    if (!f.path.even || through_lens) r.look |= COVER_BY_RAYS;
    if (through_lens && f.blur == MOST_BLUR_PX) {
        // It comes to the lens: it may be anywhere.
        pixels = ivec4(ivec2(0), ivec2(frame.image.xy) - 1);
        r.to_disc = EVERYWHERE;
    } else if (through_lens) {
        vec3 from = v - 0.5 * f.path.moved, to = v + 0.5 * f.path.moved;
        vec2 xa = seen_through_lens(from.x, -from.z, f.reach), xb = seen_through_lens(to.x, -to.z, f.reach);
        vec2 ya = seen_through_lens(-from.y, -from.z, f.reach), yb = seen_through_lens(-to.y, -to.z, f.reach);
        vec2 low = vec2(min(xa.x, xb.x), min(ya.x, yb.x)), high = vec2(max(xa.y, xb.y), max(ya.y, yb.y));
        vec2 most = vec2(MOST_BLUR_PX);
        low = clamp(frame.image.z * low, -most, most);
        high = clamp(frame.image.z * high, -most, most);
        pixels = pixels_in(pixel_of(0.5 * (low + high)), 0.5 * (high - low));
        r.to_disc = EVERYWHERE;
    } else if (!f.path.even && !f.path.near) {
        // Around the outlines at both ends.
        vec3 ends[2] = vec3[2](v - 0.5 * f.path.moved, v + 0.5 * f.path.moved);
        Outline a = outline_of(Drop(vec3(0.0), ends[0], f.reach), dot(ends[0], ends[0]));
        Outline b = outline_of(Drop(vec3(0.0), ends[1], f.reach), dot(ends[1], ends[1]));
        vec2 low = min(a.center - a.box, b.center - b.box), high = max(a.center + a.box, b.center + b.box);
        pixels = pixels_in(0.5 * (low + high), 0.5 * (high - low));
        r.to_disc = EVERYWHERE;
    } else if (f.is_beside || f.path.near) {
        // The outline is no ellipse: the rays of the pixels that may see it tell which do.
        r.center = pixel_of(vec2(0.0));
        r.to_disc = EVERYWHERE;
        vec3 from = v - 0.5 * f.path.moved, to = v + 0.5 * f.path.moved;
        vec2 x = passes_along(vec2(from.x, -from.z), vec2(to.x, -to.z), f.reach);
        vec2 y = passes_along(vec2(-from.y, -from.z), vec2(-to.y, -to.z), f.reach);
        vec2 low = vec2(x.x, y.x), high = vec2(x.y, y.y);
        pixels = pixels_in(r.center + frame.image.z * 0.5 * (low + high), frame.image.z * 0.5 * (high - low));
    }
    return pixels;
}

// Takes places for the blocks of a drop that touches so many tiles, of which there are `most`; returns how many there is room
// for.
uint take_blocks(uint touched, uint most, out uint block) {
    uint tiles = min(touched, most);
    uint before = subgroupExclusiveAdd(tiles), all_here = subgroupAdd(tiles);
    block = 0u;
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.blocks, all_here, leads, block);
    STAY_BEYOND(totals.blocks, most, leads, block);
    if (leads && all_here > 0u) ask_for_groups(min(block, most) + all_here, most);
    block += before;
    uint room = most - min(block, most);
    if (touched > room) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
    }
    return min(tiles, room);
}

// Writes a drop as two splats into the place of its one block: of its upper tiles, and of its lower ones.
void write_two_splats(uint block, Found f, uint index, uint texel, uvec2 upper, uvec2 last, uvec4 record) {
    uint node = block_node(block);
    uvec2 lower = upper + uvec2(0, 2);
    write_splat(node, f.distance2, index, f.outline.center, f.half_sides, f.opacity, texel, upper);
    push_splat(node, upper, last);
    if (NEAREST != 0u) drop_records[node / NODE] = record;
    node += NODE;
    write_splat(node, f.distance2, index, f.outline.center, f.half_sides, f.opacity, texel, lower);
    push_splat(node, lower, last);
    if (NEAREST != 0u) drop_records[node / NODE] = record;
}

// Fills a drop's blocks with its number, or leaves that to big.comp.
void fill_blocks(uint at, uint block, uint tiles) {
    bool big = tiles > MOST_TILES;
    uint few = big ? 0u : tiles;
    for (uint i = 0u; i < few; ++i) blocks[block + i] = at;
    if (big) {
        uint place = atomicAdd(totals.bigs, 1u);
        bigs[place] = uvec2(at, tiles);
        atomicMax(totals.big_groups.x, min(place + 1u, MOST_BIG_GROUPS));
    }
}

// Number of the first tile and how many tiles across and down show a drop.
uvec2 tiles_touched(Found f, ivec4 pixels, out uvec2 first) {
    first = max(uvec2(pixels.xy) / TILE, first_tile());
    uvec2 end = min(uvec2(pixels.zw) / TILE + 1u, end_tile());
    bool nowhere = any(greaterThan(pixels.xy, pixels.zw)) || any(greaterThanEqual(first, end));
    // Spread so wide that it covers less than a unit of coverage anywhere: it would take fragments all over the picture.
    nowhere = nowhere || is_lens() && !f.is_beside && f.disc > UNSEEN_RADII * f.outline.radius;
    return nowhere ? uvec2(0u) : end - first;
}

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= min(totals.larges, MAX_LARGES)) return;
    Large r;
    r.index = larges[at].index;
    Found f = find(r.index);
    if (is_spread()) {
        moves[2u * at] = vec4(f.path.moved, f.blur);
        moves[2u * at + 1u] = vec4(f.path.way, f.disc, 0.0);
    }
    r.sphere = vec4(f.drop.view, f.drop.radius);
    r.center = f.outline.center;
    // Drops are ordered by their tangents' length: of two that do not touch, the one with the shorter is
    // never behind the other. By their centres a small drop behind a large one's rim would be before it. (A
    // splat's radius is nothing beside its distance.)
    r.distance2 = floatBitsToUint(max(f.distance2 - f.radius2, 0.0)) | (is_by_hand(r.index) ? PLACED_BIT : 0u);
    bool rays = is_by_rays(f);
    uint texel = orient(r, f, at, rays), opacity = uint(opacity_at(f.distance2) * 65535.0 + 0.5);
    r.look = texel | (rays ? BY_RAYS : 0u) | (f.is_flat ? FLAT : 0u) | opacity << 16;
    uvec2 first, count = tiles_touched(f, pixels_of(r, f), first);

    ivec4 of_splats = pixels_in(f.outline.center, f.half_sides);
    uvec2 upper = uvec2(of_splats.xy) / TILE, last = uvec2(of_splats.zw) / TILE;
    bool splats = !f.is_beside && f.path.even && is_small(f.drop, f.outline, f.half_sides, f.distance2)
        && is_short(f.outline, f.path) && is_little(f.outline.radius, f.disc) && all(lessThanEqual(last - upper, uvec2(1, 2)));
    if (splats) {
        count = uvec2(1u);
        r.look |= AS_SPLATS;
    }
    r.first_tile = first.x | first.y << 16;
    r.across = count.x;
    uint tiles = take_blocks(count.x * count.y, block_room(), r.first_block), index = r.index;
    // Later passes do not ask for the drop's index: they get a number that is the same whichever part of the picture is drawn.
    r.index = number_for_chance(index, f.drop);
    larges[at] = r;
    uvec4 record = NEAREST != 0u ? record_of(index, f.drop) : uvec4(0u);
    if (NEAREST != 0u) drop_records[large_record(at)] = record;
    if (splats && tiles > 0u) write_two_splats(r.first_block, f, index, texel, upper, last, record);
    fill_blocks(at, r.first_block, tiles);
}
