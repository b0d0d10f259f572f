#version 460
#extension GL_GOOGLE_include_directive : require
// What a splat shows, by its direction, in this view; one invocation a direction, whenever the view turns. Two times
// four words: the colours of its upper and its lower half on the screen, the places of its two brightest glints, the
// light of the first for a radius of a pixel; that of the second, that of all but the first. See src/passes/glints.rs.
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

const uint EDGE = 4u; // texels of the picture that the halves are means of

void main() {
    uint texel = gl_GlobalInvocationID.x;
    if (texel >= SINGLE_TEXELS || pictures[texel] == NO_PICTURE) return;
    vec3 n = texel_direction(texel), u, w;
    basis(n, u, w);
    vec3 v = to_view(n);
    // How a step on the drop moves on the screen, in the outline's mean radii: that outline is larger by
    // depth^-1.5 than one on the axis of view.
    float depth = max(-v.z, 1e-3);
    mat3x2 onto = mat3x2(vec2(1.0, 0.0) * sqrt(depth), vec2(0.0, -1.0) * sqrt(depth),
                         vec2(v.x, -v.y) * inversesqrt(depth));

    // A texel that the line between the halves cuts goes to both by its parts.
    vec2 down = vec2((onto * to_view(u)).y, (onto * to_view(w)).y);
    down *= 0.5 * float(EDGE) / max(length(down), 1e-3);
    vec4 above = vec4(0.0), below = vec4(0.0);
    for (uint i = 0u; i < EDGE * EDGE; ++i) {
        vec2 st = (vec2(i % EDGE, i / EDGE) + 0.5) * (2.0 / float(EDGE)) - 1.0;
        float inside = clamp((1.0 - length(st)) * 0.5 * float(EDGE) + 0.5, 0.0, 1.0);
        float lower = clamp(dot(st, down) + 0.5, 0.0, 1.0);
        vec4 light = inside * vec4(unpack_radiance(pictures[picture_word(texel, EDGE) + i]), 1.0);
        above += (1.0 - lower) * light;
        below += lower * light;
    }
    // Their mean is that of the whole picture, with what is no glint.
    vec3 upper_color = above.rgb / above.a, lower_color = below.rgb / below.a;
    vec3 share = unpack_radiance(pictures[picture_word(texel, 1u)]) / max(0.5 * (upper_color + lower_color), 1e-30);
    FarGlints glints = far_glints[texel];
    vec3 others = vec3(glints.first_at.w, glints.first.w, glints.second_at.w), spread = others / 3.14159265;
    vec3 a = to_view(glints.first_at.xyz), b = to_view(glints.second_at.xyz);
    splat_table[2u * texel] = uvec4(
        pack_radiance(share * upper_color + spread), pack_radiance(share * lower_color + spread),
        packSnorm4x8(vec4(onto * a, onto * b) / LONGEST_OFFSET), pack_radiance(glints.first.rgb));
    splat_table[2u * texel + 1u] =
        uvec4(pack_radiance(glints.second.rgb), pack_radiance(glints.second.rgb + others), 0u, 0u);
}
