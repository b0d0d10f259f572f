#ifndef SPLAT_TEXELS_GLSL
#define SPLAT_TEXELS_GLSL
// What splats show, an entry at a time.
#include "by_texels.glsl"
#include "splat_table.glsl"

layout(set = 1, binding = 14) uniform usamplerBuffer splat_texels;

uvec4 splat_of(uint entry) {
    return BY_TEXELS != 0u ? texelFetch(splat_texels, int(entry)) : splat_table[entry];
}
#endif
