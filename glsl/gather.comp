#version 460
#extension GL_GOOGLE_include_directive : require
// The drops of the cells in view: where each is, whether it is in view, which tiles it touches; one
// invocation a record. See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "octahedron.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint MAX_BIGS = 1;
layout(constant_id = 1) const uint MAX_RECORDS = 1;
layout(constant_id = 2) const uint SLABS = 1;
layout(constant_id = 3) const float RAYS_PX = 8.0; // radius from which a drop is drawn by rays
layout(constant_id = 4) const uint HAS_PLACED = 0;
layout(constant_id = 5) const uint MAY_RAY = 0; // 1: drops of few tiles may be drawn by rays

const float NEAR_RADII = 32.0; // nearer than this a drop does not look like a far one: over 1.4°

layout(std430, set = 0, binding = 15) readonly buffer PlacedDrops { Placed placed[]; };
#define COUNTERS_BINDING 16
#include "counters.glsl"

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= min(totals.records, MAX_RECORDS)) return;
    uint index = record_index[at];
    vec3 p = relative_integer(index);
    float radius = frame.units.w;
    if (HAS_PLACED != 0u && index >= frame.camera_place.w) {
        Placed drop = placed[index - frame.camera_place.w];
        p = relative_placed(drop);
        radius = drop.high.w;
    }
    vec3 v = view_space(p);
    float distance2;
    uint what = sighting(v, radius, distance2);
    if (what == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
    if (what == VISIBLE) atomicAdd(counters.visible[gl_WorkGroupID.x & 63u], 1u);

    bool beside = what == BESIDE_CAMERA;

    // The outline: an ellipse about `center` with these semi-axes, radial and tangential (see
    // sprite.glsl). `across` is the tangential direction, `out_r` how the radial one leaves the ray.
    float radius2 = radius * radius, flat2 = v.z * v.z - radius2, focal = frame.image.z;
    float far = length(v.xy), distance_r = inversesqrt(distance2);
    vec2 radial = far > 0.0 ? v.xy / far : vec2(1.0, 0.0), across = vec2(-radial.y, radial.x);
    vec2 axes = focal * radius * vec2(sqrt(distance2 - radius2) / flat2, inversesqrt(flat2));
    vec2 offset = v.xy * (-v.z / flat2) * focal;
    Record r;
    r.center = 0.5 * frame.image.xy + vec2(offset.x, -offset.y);
    r.distance2 = distance2;
    bool near_by = distance2 < NEAR_RADII * NEAR_RADII * radius2;
    bool rays = beside || sqrt(axes.x * axes.y) > RAYS_PX || MAY_RAY != 0u && near_by;

    // Its picture: that of the nearest direction, turned as that direction's basis is.
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    uint texel = direction_texel(p * distance_r);
    vec3 n = texel_direction(texel), u, w;
    basis(n, u, w);
    vec3 out_r = world * vec3(radial * (-v.z * distance_r), far * distance_r);
    vec3 out_t = world * vec3(across, 0.0);
    vec2 disc_r = rays ? vec2(1.0, 0.0) : vec2(dot(out_r, u), dot(out_r, w));
    vec2 disc_t = rays ? vec2(0.0, 1.0) : vec2(dot(out_t, u), dot(out_t, w));
    r.to_disc.xy = disc_r * (radial.x / axes.x) + disc_t * (across.x / axes.y);
    r.to_disc.zw = -(disc_r * (radial.y / axes.x) + disc_t * (across.y / axes.y));
    float near = frame.camera_high.w, fade = frame.camera_low.w;
    float opacity = fade > 0.0 ? smoothstep(near, near + fade, sqrt(distance2)) : 1.0;
    r.look = texel | (rays ? BY_RAYS : 0u) | uint(opacity * 65535.0 + 0.5) << 16;

    // Pixels whose squares the outline's box meets, smoothed over one pixel.
    vec2 box = half_box(r.to_disc);
    ivec2 size = ivec2(frame.image.xy);
    ivec2 low = clamp(ivec2(ceil(r.center - box - 1.0)), ivec2(0), size);
    ivec2 high = clamp(ivec2(floor(r.center + box)), ivec2(-1), size - 1);
    if (beside) {
        // The outline is no ellipse: any pixel may see it, and its rays tell which.
        r.center = 0.5 * frame.image.xy;
        r.to_disc = vec4(1e-6, 0.0, 0.0, 1e-6);
        low = ivec2(0);
        high = size - 1;
    }
    bool shown = (what == VISIBLE || beside) && all(lessThanEqual(low, high));
    uvec2 first = uvec2(low) / TILE, count = uvec2(high) / TILE - first + 1u;
    bool big = shown && count.x * count.y > MOST_TILES;
    if (shown) {
        records[at] = r;
        record_of[index] = at;
    }
    if (shown && rays) spheres[at] = vec4(v, radius);
    if (big) {
        uint place = atomicAdd(totals.bigs, 1u);
        if (place < MAX_BIGS) {
            bigs[place] = at;
            atomicMax(totals.big_groups.x, place + 1u);
        } else {
            atomicAdd(counters.lost, 1u);
        }
        atomicAdd(counters.large_count, 1u);
    }
    uint places[MOST_TILES / 2];
    for (uint w = 0u; w < MOST_TILES / 2u; ++w) places[w] = 0u;
    if (shown && !big) {
        uint slot = (first.y * tiles_across() + first.x) * SLABS + slab_of(distance2, SLABS);
        uint x = 0u, y = 0u, i = 0u;
        do {
            uint place = atomicAdd(slabs[slot + (y * tiles_across() + x) * SLABS], 1u);
            uint half_word = min(place, 0xffffu) << (16u * (i & 1u));
            for (uint w = 0u; w < MOST_TILES / 2u; ++w) places[w] |= i / 2u == w ? half_word : 0u;
            ++i;
            if (++x == count.x) {
                x = 0u;
                ++y;
            }
        } while (y < count.y);
    }
    uint bin = at * BIN_WORDS;
    bins[bin] = first.x | first.y << 16;
    bins[bin + 1u] = shown ? count.x | count.y << 16 : 0u;
    if (shown && !big) {
        for (uint w = 0u; w < MOST_TILES / 2u; ++w) bins[bin + 2u + w] = places[w];
    }
}
