// Where the pictures of src/passes/appearance.rs lie: for each direction a pyramid of square
// pictures of 1, 2, 4, 8 and 16 texels an edge, one word a texel.

const uint PYRAMID = 341; // 1 + 4 + 16 + 64 + 256

// Word of texel `at` of the picture with `edge` texels, of a direction.
uint appearance_word(uint direction, uint edge, uvec2 at) {
    return direction * PYRAMID + (edge * edge - 1u) / 3u + at.y * edge + at.x;
}
