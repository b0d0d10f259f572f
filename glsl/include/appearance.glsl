// Where the pictures of src/passes/appearance.rs lie: for each direction a pyramid of square
// pictures of 1, 2, 4, 8 and 16 texels an edge, one word a texel.

const uint PYRAMID = 341; // 1 + 4 + 16 + 64 + 256
const uint NO_COLOR = 0xffffffffu; // a pixel of a block that its drop does not cover

// First word of the picture with `edge` texels of a direction.
uint picture_word(uint direction, uint edge) {
    return direction * PYRAMID + (edge * edge - 1u) / 3u;
}
