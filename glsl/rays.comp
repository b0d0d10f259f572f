#version 460
#extension GL_GOOGLE_include_directive : require
// The colours of drops too large for their prefiltered pictures, by rays; one invocation a pixel of a
// block, eight a block. See src/passes/composite.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "divided.glsl"
#include "environment.glsl"
#include "light_model.glsl"
#include "optics.glsl"
#include "places.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(local_size_x = 256) in;
layout(push_constant) uniform Push { uint piece; } push; // which of those among which blocks are shared out

#include "maps.glsl"

#include "drop_light.glsl"
#include "shape.glsl"
#include "shape_light.glsl"
#include "source_light.glsl"

#include "behind.glsl"

#include "ray_in_shape.glsl"
#include "ray_count.glsl"

// Fewest rays of a pixel of a drop that is no sphere: beside the rim, where light is reflected totally, one is speckled.
const uint LEAST_FLAT_RAYS = 4;

// The mean over those of some places where the ray hits the drop,
// by the closed form. The places fill the part of the pixel that the box around the outline leaves,
// from `low` to `high`: a drop far smaller than the pixel gets all of them. `pixels`: its radius. Places where the drop is
// farther than `behind` count as if they missed it.
uint color(vec2 low, vec2 high, vec4 sphere, Body body, float pixels, vec2 moved, float behind, bool is_moving) {
    RestingRays mean = RestingRays(vec3(0.0), 0.0, 0.0);
    float hits = 0.0;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec2 extent = high - low;
    // The samples' spacing; half of it for drops under two pixels, whose coarse levels are blurred as
    // much again by interpolation. (Eight pixels, 64 rays: RMS error 1.3 grey levels, by half 2.6;
    // under a pixel, 4 rays: 6.6 and by half 4.3.)
    float spacing = clamp(0.25 * pixels, 0.5, 1.0);
    vec3 middle = normalize(ray_through(0.5 * (low + high))), aside = cross(cross(middle, sphere.xyz), middle) / -sphere.w;
    uint rays = rays_at(body.is_flat ? 1.0 : length(aside), pixels, is_beside(sphere.xyz, sphere.w));
    if (body.is_flat) rays = max(rays, LEAST_FLAT_RAYS);
    // None for a drop that moves.
    if (MOTION != 0u && is_moving) rays = 0u;
    float step = spacing * sqrt(extent.x * extent.y / float(rays)) / pixels;
    // The condition stands last: where it stands first, llvmpipe runs a loop's body once more, with no lane in it.
    uint first = rays, before = 0u, i = 0u;
    if (i < rays) do {
        vec3 d = normalize(ray_through(low + fract(place_of(i++ - before, rays - before) + moved) * extent));
        // From the centre to the ray; the cross product keeps its digits at the rim.
        vec3 to_ray = cross(cross(d, sphere.xyz), d) / -sphere.w;
        float b = length(to_ray);
        bool hit = b < 1.0 && dot(d, sphere.xyz) > 0.0;
        // Beyond the rim, the rim, for pixels that no sample hits but the outline touches.
        float held = min(b, 0.99999), weight = hit ? 1.0 : 1e-4;
        if (body.is_flat) {
            RayInShape flat_ray = ray_in_shape(body, to_ray, d);
            weight = flat_ray.hits && dot(d, sphere.xyz) > 0.0 ? 1.0 : 1e-4;
            hits += weight;
            if (HAS_DEPTH != 0u && dot(d, sphere.xyz) + sphere.w * front_in(flat_ray, body) >= behind) weight = 1e-4;
            add(mean, light_in(flat_ray, body, world, step, false), weight);
        } else {
            hits += weight;
            if (HAS_DEPTH != 0u && dot(d, sphere.xyz) - sphere.w * sqrt((1.0 - held) * (1.0 + held)) >= behind) weight = 1e-4;
            Intersection e = Intersection(d, to_ray / max(b, 1e-9), held, sqrt((1.0 - held) * (1.0 + held)));
            add(mean, drop_light(environment_map, e, world, step), weight);
        }
        if (ARE_FEW && i == first) {
            // More of them, with places of their own.
            rays = max(rays, min(rays_for(mean), UNSURE_RAYS));
            step *= sqrt(float(first) / float(rays));
            before = first;
        }
    } while (i < rays);
    // A drop beside the camera has no outline that would tell where it is: its rays do.
    return (body.is_flat ? !body.has_outline : is_beside(sphere.xyz, sphere.w)) && hits < 0.5 * float(rays) ? NO_COLOR : pack_radiance(mean.sum / mean.weights);
}

#include "moving_rays.glsl"
#include "lens.glsl"
#include "lens_rays.glsl"

// What rays need of a large drop beside its sphere; `around`: its outline's box, from the centre on.
Body body_of(uint drop, Large r, out vec4 around) {
    vec4 m = r.to_disc;
    vec2 box = vec2(length(m.wz), length(m.yx)) / abs(m.x * m.w - m.y * m.z);
    Body body;
    body.is_flat = SHAPE != SPHERES && (r.look & FLAT) != 0u;
    around = vec4(-box, box);
    if (body.is_flat) {
        LargeShape l = large_shapes[drop];
        body.shape = l.shape;
        body.has_outline = has_outline(l);
        around = l.box;
    }
    return body;
}

// Adds what rays found covered to a block's coverage, which is nothing before: whole units of 1/65535.
void add_coverage(uint node, uint pixel, uint units) {
    atomicOr(nodes[node + COVERAGE + pixel / 2u], units << 16u * (pixel & 1u));
}

// Writes what rays through a lens find of a drop in a pixel.
void write_lens_color(uint node, uint pixel, uint drop, Large r, Body body, vec2 corner, vec3 motion, float pixels, float behind) {
    float covered;
    bool spreads = SHAPE >= TRACED && body.is_flat ? !has_own_spots(drop) : has_spread_glints(drop, r.sphere);
    uint found = lens_color(corner, r.sphere, body, motion, pixels, moves[2u * drop].w, place_moved(r.index), behind, spreads, covered);
    nodes[node + COLORS + pixel] = found;
    if ((r.look & COVER_BY_RAYS) == 0u) return;
    // The part of a unit that is left over is rounded by chance, so that what is faint keeps its light on the mean.
    float units = covered * float(r.look >> 16) + fract(dot(corner, vec2(0.75487767, 0.56984029)) + place_moved(r.index).x);
    add_coverage(node, pixel, min(uint(units), 65535u));
}

// Writes what rays find of a drop that moves; `around`: the box of its way, from the outline's centre on.
void write_moving_color(uint node, uint pixel, Large r, Body body, vec2 corner, vec4 around, vec3 motion, float pixels, float behind) {
    bool is_cover = (r.look & COVER_BY_RAYS) != 0u;
    vec2 low = corner, high = corner + 1.0;
    // What part of the whole pixel is covered rays tell for themselves, and the outline of another moment may reach farther.
    if (!is_cover) {
        low = clamp(r.center + around.xy, corner, corner + 1.0);
        high = max(clamp(r.center + around.zw, corner, corner + 1.0), low + 1e-3);
    }
    float covered;
    nodes[node + COLORS + pixel] = moving_color(corner, low, high, r.sphere, body, motion, pixels, place_moved(r.index), behind, covered);
    if (is_cover) add_coverage(node, pixel, uint(covered * float(r.look >> 16) + 0.5));
}

void main() {
    uint ray_blocks = totals.ray_blocks; // before any branch: there CPU drivers read what is the same for all lanes once
    uint invocation = group_number() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    uint in_piece = invocation / PIXELS, number = push.piece * RAY_PIECE + in_piece, pixel = invocation % PIXELS;
    if (in_piece >= RAY_PIECE || number >= ray_blocks) return;
    uint at = ray_block(number), drop = large_of_block(at);
    Large r = large_at(drop);
    uint place = at - r.first_block;
    uvec2 tile = uvec2(r.first_tile & 0xffffu, r.first_tile >> 16)
        + divided(place, r.across).yx;
    vec2 corner = vec2(tile * TILE + uvec2(pixel % TILE.x, pixel / TILE.x));
    vec4 around;
    Body body = body_of(drop, r, around);
    vec2 low = clamp(r.center + around.xy, corner, corner + 1.0);
    vec2 high = clamp(r.center + around.zw, corner, corner + 1.0);
    // A pixel beside the box, which no more than the smoothed edge reaches: the nearest point.
    high = max(high, low + 1e-3);
    float d2 = dot(r.sphere.xyz, r.sphere.xyz), r2 = r.sphere.w * r.sphere.w;
    float pixels = frame.image.z * r.sphere.w * inversesqrt(max(d2 - r2, 1e-6 * r2));
    // Thousands of small drops are seen at once: their places are moved, each drop's otherwise, so that
    // all are not wrong in the same way. (Forest, 250,000 drops, 16 rays: FLIP of 8 x 8 boxes 0.039 to
    // 0.029.)
    vec2 moved = SAMPLES > 1u && pixels < 2.0 ? place_moved(r.index) : vec2(0.0);
    float behind = HAS_DEPTH != 0u ? distance_behind[tile_number(tile) * PIXELS + pixel] : 0.0;
    uint node = block_node(at);
    vec3 motion = vec3(0.0);
    if (is_exposed()) motion = moves[2u * drop].xyz;
    if (is_lens() && moves[2u * drop].w > 0.0) {
        write_lens_color(node, pixel, drop, r, body, corner, motion, pixels, behind);
        return;
    }
    bool is_moving = motion != vec3(0.0);
    uint at_rest = color(low, high, r.sphere, body, pixels, moved, behind, is_moving);
    if (!is_moving) {
        nodes[node + COLORS + pixel] = at_rest;
        return;
    }
    vec2 wide = 0.5 * abs(moves[2u * drop + 1u].xy);
    write_moving_color(node, pixel, r, body, corner, around + vec4(-wide, wide), motion, pixels, behind);
}
