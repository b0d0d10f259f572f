#version 460
#extension GL_GOOGLE_include_directive : require
// The picture: every tile's drops over one another, front to back, the sky behind; one invocation a
// tile. See src/passes/composite.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "optics.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(local_size_x = 32) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint MAX_ENTRIES = 1;
layout(constant_id = 2) const uint MAX_LARGE = 1;
layout(constant_id = 3) const float APPEARANCE_PX = 8.0; // largest radius shown by its picture
layout(constant_id = 4) const uint SAMPLES = 4;          // rays a pixel of a larger drop
layout(constant_id = 5) const uint INTERNAL_REFLECTIONS = 2;
layout(constant_id = 6) const uint CONSERVE = 1;

layout(set = 0, binding = 15) uniform sampler2D environment_map;
#define COUNTERS_BINDING 16
#include "counters.glsl"
layout(std430, set = 0, binding = 17) readonly buffer Appearance { uint appearance[]; };
// Radiance so far and transmittance of every pixel, tile by tile.
layout(std430, set = 0, binding = 18) buffer Layers { vec4 layers[]; };
// The result: four halves a pixel, row by row.
layout(std430, set = 0, binding = 19) writeonly buffer Radiance { uvec2 radiance_out[]; };

#include "drop_light.glsl"

const float OPAQUE = 1.0 / 1024.0; // transmittance under which nothing behind is looked at

void blend(uint at, vec4 light) {
    vec4 layer = layers[at];
    layers[at] = vec4(layer.rgb + layer.a * light.a * light.rgb, layer.a * (1.0 - light.a));
}

// Part of pixel square that the drop covers, at `offset` pixels from its centre.
// Under a pixel of radius: its box of equal area against the square, which keeps the sum over all
// pixels exact at every place. Above: the distance from an edge that keeps the disc's area, π R² =
// π (R'² + 1/12) for a ramp one pixel wide.
float coverage(vec2 offset, float disc, float radius, vec2 half_side) {
    vec2 overlap = max(min(offset + 0.5, half_side) - max(offset - 0.5, -half_side), 0.0);
    float edge = sqrt(max(radius * radius - 1.0 / 12.0, 0.0)) + 0.5 - disc * radius;
    return radius < 1.0 ? overlap.x * overlap.y : clamp(edge, 0.0, 1.0);
}

// A drop by its pixel rays: the closed form at SAMPLES places of the pixel (the sequence R2 of
// Roberts 2018). `pixels`: its radius.
vec4 by_rays(vec2 pixel, vec3 center, float radius, float pixels) {
    vec3 sum = vec3(0.0);
    float hits = 0.0;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    for (uint i = 0u; i < SAMPLES; ++i) {
        vec2 place = fract(0.5 + float(i) * vec2(0.7548776662, 0.5698402910));
        vec2 offset = pixel + place - 0.5 * frame.image.xy;
        vec3 d = normalize(vec3(offset.x, -offset.y, -frame.image.z));
        vec3 to_ray = cross(cross(center, d), d) / radius;
        float b = length(to_ray);
        if (b < 1.0 && dot(d, center) > 0.0) {
            Encounter e = Encounter(d, to_ray / max(b, 1e-9), b, sqrt((1.0 - b) * (1.0 + b)));
            sum += drop_light(environment_map, e, world, inversesqrt(float(SAMPLES)) / pixels);
            hits += 1.0;
        }
    }
    return vec4(sum / max(hits, 1.0), hits / float(SAMPLES));
}

// A drop that lies in the tile's list.
void blend_record(Record r, vec4 sphere, ivec2 corner, ivec2 limit, uint layer) {
    vec4 m = r.to_disc;
    float det = abs(m.x * m.w - m.y * m.z);
    vec2 box = vec2(length(vec2(m.w, m.z)), length(vec2(m.y, m.x))) / det;
    float radius = inversesqrt(det);
    // Half sides of a box of the disc's area, in the shape of the box around it.
    vec2 half_side = box * (0.8862269 * radius * inversesqrt(box.x * box.y));
    float opacity = float(r.look >> 16) / 65535.0;
    uint direction = r.look & 0xffffu;
    bool rays = radius > APPEARANCE_PX;
    // A picture whose texels are about as large as a pixel.
    uint level = uint(clamp(log2(2.0 * radius) + 0.5, 0.0, 4.0));
    uint edge = 1u << level;
    uint base = direction * PYRAMID + (edge * edge - 1u) / 3u;
    // The smallest pictures whole: no fetches within the pixel loop.
    uint row = edge == 2u ? 2u : 0u, column = edge == 2u ? 1u : 0u;
    vec3 p00 = unpack_radiance(appearance[base]);
    vec3 p10 = unpack_radiance(appearance[base + column]);
    vec3 p01 = unpack_radiance(appearance[base + row]);
    vec3 p11 = unpack_radiance(appearance[base + row + column]);

    ivec2 low = max(ivec2(ceil(r.center - box - 1.0)), corner);
    ivec2 high = min(ivec2(floor(r.center + box)), limit);
    ivec2 at = low;
    bool more = all(lessThanEqual(low, high));
    while (more) {
        vec2 offset = vec2(at) + 0.5 - r.center;
        vec2 st = m.xy * offset.x + m.zw * offset.y;
        vec4 light;
        light.a = coverage(offset, length(st), radius, half_side);
        vec2 place = clamp((0.5 * st + 0.5) * float(edge) - 0.5, 0.0, float(edge) - 1.0);
        vec2 part = fract(place);
        light.rgb = mix(mix(p00, p10, part.x), mix(p01, p11, part.x), part.y);
        for (bool once = level >= 2u && !rays; once; once = false) {
            uvec2 texel = uvec2(place);
            uvec2 next = min(texel + 1u, uvec2(edge - 1u));
            vec3 upper = mix(unpack_radiance(appearance[base + texel.y * edge + texel.x]),
                             unpack_radiance(appearance[base + texel.y * edge + next.x]), part.x);
            vec3 lower = mix(unpack_radiance(appearance[base + next.y * edge + texel.x]),
                             unpack_radiance(appearance[base + next.y * edge + next.x]), part.x);
            light.rgb = mix(upper, lower, part.y);
        }
        for (bool once = rays; once; once = false) {
            light = by_rays(vec2(at), sphere.xyz, sphere.w, radius);
        }
        light.a *= opacity;
        ivec2 within = at - corner;
        blend(layer + uint(within.y) * TILE + uint(within.x), light);
        ++at.x;
        if (at.x > high.x) {
            at.x = low.x;
            ++at.y;
        }
        more = at.y <= high.y;
    }
}

// A drop too large for the tiles' lists.
void blend_large(vec4 sphere, ivec2 corner, ivec2 limit, uint layer) {
    float d2 = dot(sphere.xyz, sphere.xyz), r2 = sphere.w * sphere.w;
    float near = frame.camera_high.w, fade = frame.camera_low.w;
    float opacity = fade > 0.0 ? smoothstep(near, near + fade, sqrt(d2)) : 1.0;
    // Radius in pixels where the ray along its centre meets the image plane, for the fan only.
    float pixels = frame.image.z * sphere.w / sqrt(max(d2 - r2, 1e-6 * r2));
    // Does the cone around the tile meet the drop's?
    vec2 middle = 0.5 * vec2(corner + limit + 1) - 0.5 * frame.image.xy;
    vec3 axis = vec3(middle.x, -middle.y, -frame.image.z);
    float reach = atan(0.7072 * float(TILE) / length(axis)) + asin(min(sphere.w * inversesqrt(d2), 1.0));
    float apart = acos(clamp(dot(axis, sphere.xyz) * inversesqrt(dot(axis, axis) * d2), -1.0, 1.0));
    ivec2 at = corner;
    bool more = apart <= reach + 1e-3;
    while (more) {
        vec4 light = by_rays(vec2(at), sphere.xyz, sphere.w, pixels);
        light.a *= opacity;
        ivec2 within = at - corner;
        blend(layer + uint(within.y) * TILE + uint(within.x), light);
        ++at.x;
        if (at.x > limit.x) {
            at.x = corner.x;
            ++at.y;
        }
        more = at.y <= limit.y;
    }
}

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uvec2 size = uvec2(frame.image.xy);
    uint across = (size.x + TILE - 1u) / TILE;
    ivec2 corner = ivec2(tile % across, tile / across) * int(TILE);
    ivec2 limit = min(corner + int(TILE), ivec2(size)) - 1;
    uint layer = tile * TILE * TILE;
    for (uint i = 0u; i < TILE * TILE; ++i) layers[layer + i] = vec4(0.0, 0.0, 0.0, 1.0);

    uint first = tiles[tile].x, end = min(first + tiles[tile].y, MAX_ENTRIES);
    uint larges = min(counters.large_count, MAX_LARGE), next_large = 0u;
    for (uint i = first; i <= end; ++i) {
        uvec2 entry = uvec2(0xffffffffu, 0u);
        if (i < end) entry = entries[i];
        // The large drops come in between, in their place.
        while (next_large < larges) {
            vec4 sphere = large[next_large];
            if (floatBitsToUint(dot(sphere.xyz, sphere.xyz)) > entry.x) break;
            blend_large(sphere, corner, limit, layer);
            ++next_large;
        }
        for (bool once = i < end; once; once = false) {
            blend_record(records[entry.y], spheres[entry.y], corner, limit, layer);
        }
    }

    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    float focal = frame.image.z;
    for (uint i = 0u; i < TILE * TILE; ++i) {
        ivec2 at = corner + ivec2(i % TILE, i / TILE);
        vec4 sum = layers[layer + i];
        for (bool once = sum.a > OPAQUE; once; once = false) {
            vec2 offset = vec2(at) + 0.5 - 0.5 * frame.image.xy;
            vec3 ray = vec3(offset.x, -offset.y, -focal);
            float far = length(ray);
            sum.rgb += sum.a * radiance(environment_map, world * ray / far, sqrt(focal / far) / far);
        }
        if (all(lessThanEqual(at, limit))) {
            uvec2 word = uvec2(packHalf2x16(sum.rg), packHalf2x16(vec2(sum.b, 1.0)));
            radiance_out[uint(at.y) * size.x + uint(at.x)] = word;
        }
    }
}
