#ifndef PICTURE_LIGHT_GLSL
#define PICTURE_LIGHT_GLSL
// The light of a pixel from a far drop's picture.
#include "appearance.glsl"
#include "by_texels.glsl"
#include "light_model.glsl"
#include "pictures.glsl"
#include "shared_exponent.glsl"

// PICTURE_TEXELS: a pass has them by texels as well.
#ifdef PICTURE_TEXELS
layout(set = 1, binding = 11) uniform usamplerBuffer picture_texels;
uint picture_at(uint word) { return BY_TEXELS != 0u ? texelFetch(picture_texels, int(word)).x : pictures[word]; }
#else
uint picture_at(uint word) { return pictures[word]; }
#endif

// Texels an edge of the picture for a drop of so many pixels of radius: texels of 0.41 to 0.82 pixels, where the finest has such.
// Between four of 0.58, light is spread as far as within a pixel: p²/4 = 1/12.
float picture_edge(float radius) {
    return exp2(clamp(floor(log2(2.0 * radius) + 1.29), 0.0, float(PICTURE_LEVEL)));
}

// How much steeper than linear light passes from texel to texel where no picture is fine enough.
float picture_steepness(float radius, float edge) {
    return max(1.0, 2.0 * radius / (0.58 * edge));
}

// Light at a place in a picture of `edge` texels an edge, between those of the four nearest. `at`: in texels from the
// middle of the first, from 0 to edge - 1.
vec3 picture_light(uint picture, float edge, float steepness, vec2 at) {
    vec2 from = floor(at), share = clamp((at - from - 0.5) * steepness + 0.5, 0.0, 1.0), next = min(from + 1.0, edge - 1.0);
    uvec4 words = picture + uvec4(from.y * edge + vec2(from.x, next.x), next.y * edge + vec2(from.x, next.x));
    vec2 columns = vec2(1.0 - share.x, share.x);
    vec4 r, g, b, weights = vec4((1.0 - share.y) * columns, share.y * columns);
    unpack_radiances(uvec4(picture_at(words.x), picture_at(words.y), picture_at(words.z), picture_at(words.w)), r, g, b);
    return vec3(dot(r, weights), dot(g, weights), dot(b, weights));
}
#endif
