#ifndef APPEARANCE_GLSL
#define APPEARANCE_GLSL
// Where the pictures of src/passes/appearance.rs lie, one word a texel: first those of one texel, of all
// directions, which splats need by the hundred thousand and caches keep; then for each direction the square
// pictures of 2, 4, 8 and 16 texels an edge; last, where a frame asks for them, those of LARGEST_EDGE.

#include "constants.glsl"

const uint SINGLE_TEXELS = DIRECTIONS * DIRECTIONS;
const uint NO_COLOR = 0xffffffffu; // a pixel of a block that its drop does not cover

// First word of the picture with `edge` texels of a direction.
uint picture_word(uint direction, uint edge) {
    if (edge == LARGEST_EDGE) return SINGLE_TEXELS * (1u + PYRAMID) + direction * (LARGEST_EDGE * LARGEST_EDGE);
    return edge == 1u ? direction : SINGLE_TEXELS + direction * PYRAMID + (edge * edge - 4u) / 3u;
}
#endif
