#version 460
#extension GL_GOOGLE_include_directive : require
// What a splat shows in this view; one invocation a direction, whenever the view turns. Four words each: by the drop's
// direction the colours of its upper and its lower half on the screen, and the mean light of flattened drops of two
// diameters; the sources' directions in view space; by its angle to each its glints (far_glints.glsl); of flattened rain the
// mean light (flat_rain.glsl). See src/passes/glints.rs.
#include "tile_buffers.glsl"
#define SPLAT_TABLE_ACCESS writeonly
#include "splat_table.glsl"
#include "octahedron.glsl"
#include "far_glints.glsl"
#include "picture_halves.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 1, binding = 0) readonly buffer FarGlintsIn { uvec4 far_glints[]; };
layout(std430, set = 1, binding = 1) readonly buffer FlatLight { uvec4 flat_light[]; };
layout(std430, set = 1, binding = 2) readonly buffer Shapes { vec4 shapes[]; };
#include "flat_rain.glsl"

vec3 to_view(vec3 world) {
    return vec3(dot(frame.right.xyz, world), dot(frame.up.xyz, world), dot(frame.back.xyz, world));
}

// Light of a far drop's images that are no points of light.
vec3 light_of_others(vec3 direction) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < source_count.x; ++i) {
        uint number = angle_number(dot(direction, sources[i].toward.xyz));
        sum += unpack_radiance(far_glints[i * GLINT_ANGLES + number].w);
    }
    return sum;
}

// What the medium shows, or drops that are shown one by one: spheres and flattened drops by their shares (src/rain/flat_sizes.rs).
vec3 light_of_rain(vec3 of_sphere, vec3 of_flat[FLAT_DIAMETERS], float sine, uint which) {
    const uint LAST = FLAT_ELEVATIONS - 1u;
    float at = (asin(clamp(sine, -1.0, 1.0)) / 3.14159265 + 0.5) * float(LAST);
    uint below = min(uint(at), LAST - 1u);
    vec4 shares = mix(tables.flat_shares[2u * below + which], tables.flat_shares[2u * below + 2u + which], at - float(below));
    vec3 sum = (1.0 - dot(shares, vec4(1.0))) * of_sphere;
    for (uint i = 0u; i < FLAT_DIAMETERS; ++i) sum += shares[i] * of_flat[i];
    return sum;
}

void main() {
    uint texel = gl_GlobalInvocationID.x;
    if (texel < MOST_SOURCES) {
        bool is_there = texel < source_count.x;
        vec3 toward = is_there ? to_view(sources[texel].toward.xyz) : vec3(0.0);
        splat_table[TOWARD_SOURCES + texel] = uvec4(floatBitsToUint(toward), uint(is_there));
    }
    // A renewed environment may have fewer sources than there is room for.
    uint entries = source_count.x * GLINT_ANGLES;
    uint end = has_flat() ? flat_rain_entry(0u) : uint(splat_table.length());
    for (uint i = texel; ANGLES + i < end; i += SINGLE_TEXELS) {
        splat_table[ANGLES + i] = i < entries ? far_glints[i] : uvec4(0u);
    }
    if (texel >= SINGLE_TEXELS || pictures[texel] == NO_PICTURE) return;
    vec3 n = texel_direction(texel), u, w;
    basis(n, u, w);
    vec3 v = to_view(n);
    vec3 mean = unpack_radiance(pictures[picture_word(texel, 1u)]), upper_color, lower_color;
    picture_halves(texel, vec2(toward_on_screen(v, to_view(u)).y, toward_on_screen(v, to_view(w)).y), upper_color, lower_color);
    // With what is no glint.
    vec3 spread = light_of_others(n) / 3.14159265;
    uvec2 flattened = uvec2(0u);
    if (has_flat()) {
        uvec4 words = flat_light[2u * texel];
        vec3 of_flat[FLAT_DIAMETERS];
        for (uint i = 0u; i < FLAT_DIAMETERS; ++i) of_flat[i] = unpack_radiance(words[i]);
        // Rain without flattened drops has none of its light from those that are placed by hand: their parts are 0.
        vec2 placed = shapes[0].zw;
        vec3 far = mean, near = (1.0 - placed.x - placed.y) * mean + placed.x * of_flat[FLAT_SPLATS.x] + placed.y * of_flat[FLAT_SPLATS.y];
        if (FLAT_RAIN != 0u) {
            far = light_of_rain(mean, of_flat, n.y, 0u);
            near = light_of_rain(mean, of_flat, n.y, 1u);
        }
        splat_table[flat_rain_entry(texel)] = uvec4(pack_radiance(far), pack_radiance(near), 0u, 0u);
        flattened = uvec2(pack_radiance(of_flat[FLAT_SPLATS.x] + spread), pack_radiance(of_flat[FLAT_SPLATS.y] + spread));
    }
    splat_table[texel] =
        uvec4(pack_radiance(upper_color + spread), pack_radiance(lower_color + spread), flattened);
}
