#ifndef PANE_PICTURES_GLSL
#define PANE_PICTURES_GLSL
// The picture before and behind a pane, and the pixels that drops touch.
#include "shared_halves.glsl"

// Four halves a pixel, row by row: without the pane, and with it.
layout(std430, set = 0, binding = 1) readonly buffer Behind { uvec2 behind[]; };
layout(std430, set = 0, binding = 2) buffer Radiance { uvec2 radiance_out[]; };
layout(std430, set = 0, binding = 8) buffer Touched {
    uvec3 touched_groups; // of an indirect dispatch over them
    uint touched_count;
    uint touched[];       // pixels, in no order: each is drawn by itself
};

#endif
