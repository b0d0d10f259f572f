#ifndef PANE_PICTURES_GLSL
#define PANE_PICTURES_GLSL
// The picture before and behind a pane, and the pixels that drops touch.
#include "shared_halves.glsl"

// Four halves a pixel, row by row: without the pane, and with it.
layout(std430, set = 0, binding = 1) readonly buffer Behind { uvec2 behind[]; };
layout(std430, set = 0, binding = 2) buffer Radiance { uvec2 radiance_out[]; };
struct TouchedList {
    uvec3 groups; // of an indirect dispatch over it
    uint count;
};
// Blocks of pixels that drops may touch, and pixels: in no order, as each is drawn by itself.
layout(std430, set = 0, binding = 8) buffer Touched {
    TouchedList lists[2];
    uint touched[]; // the pixels, with room for all; then the blocks
};

// Two words a pixel, where PANE_NEAREST: number of the nearest drop that covers a part of it, NO_CAP: none; the part that drops
// cover, as the bits of a float.
layout(std430, set = 0, binding = 12) writeonly buffer NearestCaps { uvec2 nearest_caps[]; };

// The picture behind, of which `left` is seen, and light before it. Opacity is 1 but in layers.
uvec2 before_picture(uint pixel, vec3 light, float left) {
    vec4 seen = halves_of(behind[pixel]);
    return halves(vec4(left * seen.rgb + light, 1.0 - left * (1.0 - seen.a)));
}
#endif
