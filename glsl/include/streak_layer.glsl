#ifndef STREAK_LAYER_GLSL
#define STREAK_LAYER_GLSL
// Streaks of one colour, all of them together: a streak layer. A far drop's mean colour depends on its direction alone, so all
// that is behind one another has the colour of its pixel, and only how much passes between them all is needed: a sum
// of optical depths, in no order.
//
// They are in lists by cells of the picture larger than tiles, of six kinds: squares for slanting streaks, short level
// ones and those that cover much; columns and short columns for upright ones, rows for level ones; squares of two sizes for
// drops out of focus. A tile reads the lists of its cells.
// So a streak has few entries, and each pixel meets few that pass it by.
#include "tile_buffers.glsl"

const uint SQUARES = 0, COLUMNS = 1, ROWS = 2, SHORT_COLUMNS = 3, DISCS = 4, WIDE_DISCS = 5;
const uint CELL_KINDS = CELLS_PX.length();
const float SHORT_STREAK = 12.0; // pixels
const float SLANT = 0.25;        // pixels across for one along
const float THIN = 0.6;          // most that those in columns and rows cover of a pixel
const float LINED_SHARE = 0.1;   // least that a bright source's line has in a pixel, of its image in a drop of a pixel

// `streak_layer` of tile_buffers.glsl: the first link of each cell; then links: record, a word of `nodes`, and next; then parts of streaks that have lines:
// record, and number of the part along the streak's longer axis, from the whole picture's edge on.
#define STREAK_HEADS frame.streaks.x // words
#define STREAK_LINKS frame.streaks.y // room for so many
#define LINE_PARTS frame.streaks.z // room for so many; 0: there are no lines
#define LINED_PX uintBitsToFloat(frame.streaks.w) // radius from which on a drop's streak has them

const uint LINE_PART = 16; // pixels of a part
// Sums of lines are in whole units, so that no order changes a bit.
const float LINE_UNITS = 1048576.0;

uint line_part(uint number) {
    return STREAK_HEADS + 2u * (STREAK_LINKS + number);
}

// Whether there may be streaks of one colour in this frame.
bool has_streak_layer() {
    return is_spread() && STREAK_LINKS != 0u;
}

// Pixels of the tiles, across and down.
uvec2 streak_layer_size() {
    return (end_tile() - first_tile()) * TILE;
}

uvec2 cells_of(uint kind) {
    return (streak_layer_size() + CELLS_PX[kind] - 1u) / CELLS_PX[kind];
}

// Number of the first cell of a kind.
uint first_cell(uint kind) {
    uint sum = 0u;
    for (uint before = 0u; before < CELL_KINDS; ++before) {
        uvec2 cells = cells_of(before);
        if (before < kind) sum += cells.x * cells.y;
    }
    return sum;
}
#endif
