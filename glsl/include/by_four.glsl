#ifndef BY_FOUR_GLSL
#define BY_FOUR_GLSL
// What composite.comp reads, most of it four words at a time.
#include "nodes_by_four.glsl"
#include "splat_texels.glsl"

// The environment behind, pixel by pixel of a tile after the other.
layout(std430, set = 1, binding = 1) readonly buffer Sky { uvec2 sky[]; };
// What streaks of one colour show in each tile, three halves; and the light of lines along them, packed (streak_layer_light.comp).
layout(std430, set = 1, binding = 6) readonly buffer StreakLayerLight { uvec4 streak_layer_light[]; };
// How much of it each pixel of the tiles has (lines.comp).
layout(std430, set = 1, binding = 7) readonly buffer LineSums { ivec4 line_sums[]; };
layout(set = 1, binding = 13) uniform usamplerBuffer sky_texels;
layout(set = 1, binding = 15) uniform usamplerBuffer line_texels;
layout(set = 1, binding = 16) uniform usamplerBuffer streak_layer_texels;
layout(set = 1, binding = 17) uniform usamplerBuffer link_texels;

uvec4 two_of_sky(uint pixel) {
    return BY_TEXELS != 0u ? texelFetch(sky_texels, int(pixel / 2u)) : uvec4(sky[pixel], sky[pixel + 1u]);
}

uvec4 streak_layer_of_tile(uint tile) {
    return BY_TEXELS != 0u ? texelFetch(streak_layer_texels, int(tile)) : streak_layer_light[tile];
}

ivec4 lines_of_row(uint row) {
    return BY_TEXELS != 0u ? ivec4(texelFetch(line_texels, int(row))) : line_sums[row];
}
#endif
