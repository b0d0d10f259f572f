#ifndef DROP_GLSL
#define DROP_GLSL
// A drop, and those that are placed by hand.
#include "by_texels.glsl"
#include "rain.glsl"

layout(std430, set = 1, binding = 3) readonly buffer PlacedDrops { Placed placed[]; };
layout(set = 1, binding = 23) uniform usamplerBuffer placed_texels;

Placed placed_at(uint number) {
    if (BY_TEXELS == 0u) return placed[number];
    int at = int(2u * number);
    uvec4 rest = texelFetch(placed_texels, at + 1);
    return Placed(uintBitsToFloat(texelFetch(placed_texels, at)), uintBitsToFloat(rest.xyz), rest.w);
}

struct Drop {
    vec3 relative; // centre, from the camera, along the world's axes
    vec3 view;     // the same in view space
    float radius;
};

// How far each placed drop moves while the shutter is open, world axes.
layout(std430, set = 1, binding = 4) readonly buffer PlacedMotions { vec4 placed_motions[]; };
#endif
