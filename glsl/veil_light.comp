#version 460
#extension GL_GOOGLE_include_directive : require
// What the streaks of the veil show, the mean light of a far drop, at the middle of each tile, and the lines that the
// brightest source draws along them; one invocation a tile, when the view turns. See src/passes/composite.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "tile_buffers.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#define SOURCES_BINDING 17
#include "sources.glsl"
#include "bow.glsl"
layout(std430, set = 0, binding = 19) readonly buffer Bow { vec4 bow[]; };
#include "far_light.glsl"
#include "far_glints.glsl"
layout(std430, set = 0, binding = 16) readonly buffer SplatTable { uvec4 splat_table[]; };

layout(local_size_x = 64) in;

layout(constant_id = 19) const uint GLINTS = 0; // 1: there are bright sources

layout(std430, set = 0, binding = 22) writeonly buffer VeilLight { uvec4 veil_light[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

// The light of the first image of the brightest source, packed; after all tiles' words where it and the second are, in radii
// from the middle of a drop, and how much of its light the second has.
uint light_of_line(uint tile, vec3 ray, vec3 d) {
    uvec4 images = uvec4(0u);
    vec3 toward = d;
    float brightest = 0.0;
    for (uint i = 0u; i < source_count.x; ++i) {
        uvec4 other = splat_table[ANGLES + i * GLINT_ANGLES + angle_number(dot(d, sources[i].toward.xyz))];
        float light = dot(unpack_radiance(other.y), LUMINANCE);
        if (light <= brightest) continue;
        brightest = light;
        images = other;
        toward = sources[i].toward.xyz;
    }
    vec2 on_screen = toward_on_screen(ray, toward * mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz)) * inversesqrt(max(-ray.z, 1e-3)), places = unpackHalf2x16(images.x);
    float share = dot(unpack_radiance(images.z), LUMINANCE) / max(brightest, 1e-30);
    veil_light[TILE_COUNT + tile] =
        uvec4(packHalf2x16(places.x * on_screen), packHalf2x16(places.y * on_screen), floatBitsToUint(share), 0u);
    return images.y;
}

void main() {
    uint tile = group_number() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uvec2 at = first_tile() + uvec2(tile % tiles_across(), tile / tiles_across());
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec3 ray = normalize(ray_through((vec2(at) + 0.5) * vec2(TILE)));
    vec3 d = world * ray, c = far_light(d);
    uint of_line = GLINTS != 0u ? light_of_line(tile, ray, d) : 0u;
    veil_light[tile] = uvec4(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 0.0)), of_line, 0u);
}
