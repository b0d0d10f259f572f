#version 460
#extension GL_GOOGLE_include_directive : require
// What a splat shows, by its direction, in this view: its colour, and its two brightest glints; one invocation a
// direction, whenever the view turns. See src/passes/glints.rs.
#include "frame.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "far_glints.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 2) readonly buffer FarGlintsIn { FarGlints far_glints[]; };
layout(std430, set = 0, binding = 3) readonly buffer Pictures { uint pictures[]; };
layout(std430, set = 0, binding = 4) writeonly buffer SplatTable { uvec4 splat_table[]; };

vec3 to_view(vec3 world) {
    return vec3(dot(frame.right.xyz, world), dot(frame.up.xyz, world), dot(frame.back.xyz, world));
}

void main() {
    uint texel = gl_GlobalInvocationID.x;
    if (texel >= SINGLE_TEXELS) return;
    FarGlints glints = far_glints[texel];
    vec3 v = to_view(texel_direction(texel)), a = to_view(glints.first_at.xyz), b = to_view(glints.second_at.xyz);
    // How a step on the drop moves on the screen, in the outline's mean radii: that outline is larger by
    // depth^-1.5 than one on the axis of view.
    float depth = max(-v.z, 1e-3);
    mat3x2 onto = mat3x2(vec2(1.0, 0.0) * sqrt(depth), vec2(0.0, -1.0) * sqrt(depth),
                         vec2(v.x, -v.y) * inversesqrt(depth));
    vec3 others = vec3(glints.first_at.w, glints.first.w, glints.second_at.w);
    splat_table[texel] = uvec4(
        pack_radiance(unpack_radiance(pictures[picture_word(texel, 1u)]) + others / 3.14159265),
        packSnorm4x8(vec4(onto * a, onto * b) / LONGEST_OFFSET), pack_radiance(glints.first.rgb),
        pack_radiance(glints.second.rgb));
}
