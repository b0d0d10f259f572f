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
layout(std430, set = 0, binding = 19) readonly buffer Bow { FarImages bow[]; };
#include "far_light.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 19) const uint GLINTS = 0; // 1: there are bright sources

layout(std430, set = 0, binding = 22) writeonly buffer VeilLight { uvec4 veil_light[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

// Where on the screen a far drop in a direction shows what it shows `aside`, unit vectors in view space: in radii of a disc
// of its outline's area.
vec2 on_screen(vec3 ray, vec3 aside) {
    float depth = max(-ray.z, 0.01);
    vec2 off = vec2(aside.x, -aside.y) / depth + vec2(ray.x, -ray.y) * (aside.z / (depth * depth));
    return off * (depth * sqrt(depth));
}

// The light of the first image of the brightest source, packed; after all tiles' words where it and the second are, in radii
// from the middle of a drop, and how much of its light the second has.
uint light_of_line(uint tile, vec3 ray, vec3 d) {
    FarImages images = FarImages(vec4(0.0), vec4(0.0), vec4(0.0));
    vec3 toward = d;
    for (uint i = 0u; i < source_count.x; ++i) {
        FarImages other = bow[i * BOW_ANGLES + uint(angle_in_bow(d, sources[i].toward.xyz) + 0.5)];
        if (dot(other.first.rgb, LUMINANCE) <= dot(images.first.rgb, LUMINANCE)) continue;
        images = other;
        toward = sources[i].toward.xyz;
    }
    vec3 aside = toward * mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) - ray * dot(d, toward);
    vec2 to_source = on_screen(ray, aside * inversesqrt(max(dot(aside, aside), 1e-12)));
    float share = dot(images.second.rgb, LUMINANCE) / max(dot(images.first.rgb, LUMINANCE), 1e-30);
    veil_light[TILE_COUNT + tile] = uvec4(packHalf2x16(images.first.w * to_source), packHalf2x16(images.second.w * to_source),
                                          floatBitsToUint(share), 0u);
    return pack_radiance(images.first.rgb);
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
