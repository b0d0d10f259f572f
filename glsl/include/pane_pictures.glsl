#ifndef PANE_PICTURES_GLSL
#define PANE_PICTURES_GLSL
// The picture before and behind a pane, and the pixels that drops touch.

// Four halves a pixel, row by row: without the pane, and with it.
layout(std430, set = 0, binding = 1) readonly buffer Behind { uvec2 behind[]; };
layout(std430, set = 0, binding = 2) buffer Radiance { uvec2 radiance_out[]; };
layout(std430, set = 0, binding = 8) buffer Touched {
    uvec3 touched_groups; // of an indirect dispatch over them
    uint touched_count;
    uint touched[];       // pixels, in no order: each is drawn by itself
};

vec4 halves_of(uvec2 word) {
    return vec4(unpackHalf2x16(word.x), unpackHalf2x16(word.y));
}

uvec2 halves(vec4 pixel) {
    pixel = min(pixel, vec4(65504.0));
    return uvec2(packHalf2x16(pixel.xy), packHalf2x16(pixel.zw));
}
#endif
