#ifndef DROP_GLSL
#define DROP_GLSL
// A drop, and those that are placed by hand.
#include "rain.glsl"

layout(std430, set = 1, binding = 3) readonly buffer PlacedDrops { Placed placed[]; };

struct Drop {
    vec3 relative; // centre, from the camera, along the world's axes
    vec3 view;     // the same in view space
    float radius;
};

// How far each placed drop moves while the shutter is open, world axes.
layout(std430, set = 1, binding = 4) readonly buffer PlacedMotions { vec4 placed_motions[]; };
#endif
