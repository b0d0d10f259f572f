// What the passes of src/passes/tiles.rs and composite.rs hand to each other. A tile has 4 x 2 pixels:
// so few that one invocation holds them in registers.
//
// CPU drivers run both sides of every branch, every loop once more than it is needed, and pay for
// each word that a lane reads or writes. So the passes are many and each does one thing for every
// lane; what few drops need has passes of its own.

const uvec2 TILE = uvec2(4, 2);
const uint PIXELS = TILE.x * TILE.y;
const uint IS_BLOCK = 0x80000000u;
const uint BY_RAYS = 0x8000u;
const uint MOST_TILES = 12; // of a drop that one invocation enters into lists
const uint BIN_WORDS = 2 + MOST_TILES / 2;

// A drop in view as its pixels need it.
struct Record {
    vec2 center;     // of its outline, pixels
    float distance2; // squared distance of its centre
    uint look;       // number of its direction, 12 bits; BY_RAYS; opacity, upper 16 bits
    vec4 to_disc;    // columns of the matrix from pixel offsets to (s, t) of the unit disc
};

// Drop indices, cell by cell; never changes.
layout(std430, set = 0, binding = 1) readonly buffer DropOrder { uint drop_order[]; };
// First place in that of each cell.
layout(std430, set = 0, binding = 2) readonly buffer CellFirst { uint cell_first[]; };
layout(std430, set = 0, binding = 3) buffer Totals {
    uvec4 record_groups; // of indirect dispatches: over the records,
    uvec4 big_groups;    // over the big drops, one group each,
    uvec4 block_groups;  // over the blocks
    uint records;
    uint entries;
    uint bigs;
    uint blocks;
} totals;
layout(std430, set = 0, binding = 4) buffer Records { Record records[]; };
// Centre in view space and radius of each record that is drawn by rays.
layout(std430, set = 0, binding = 5) buffer Spheres { vec4 spheres[]; };
// Index of each record's drop.
layout(std430, set = 0, binding = 6) buffer RecordIndex { uint record_index[]; };
// Record of each drop that has one.
layout(std430, set = 0, binding = 7) buffer RecordOf { uint record_of[]; };
// For each record BIN_WORDS words: first tile, x and y in 16 bits each; tiles across and down likewise,
// 0: none; its place in the slab of each of them, 16 bits each.
layout(std430, set = 0, binding = 8) buffer Bins { uint bins[]; };
// For each tile and slab of distance: number of drops that touch few tiles; later, where they begin.
layout(std430, set = 0, binding = 9) buffer Slabs { uint slabs[]; };
// Likewise of drops that touch many; later, where they begin, then where they end.
layout(std430, set = 0, binding = 14) buffer BigSlabs { uint big_slabs[]; };
// For each tile: first entry, number of entries.
layout(std430, set = 0, binding = 10) buffer Tiles { uvec2 tiles[]; };
// Distance (as bits, which sort as the distance does) and drop index; or block with IS_BLOCK.
layout(std430, set = 0, binding = 11) buffer Entries { uvec2 entries[]; };
// Records of the drops that touch more than MOST_TILES tiles.
layout(std430, set = 0, binding = 12) buffer Bigs { uint bigs[]; };
// For each block, the pixels of a tile that a drop covers by rays: record, tile.
layout(std430, set = 0, binding = 13) buffer Blocks { uvec2 blocks[]; };

uint tiles_across() {
    return (uint(frame.image.x) + TILE.x - 1u) / TILE.x;
}

// Slabs of equal volume: a tile sees about as many drops in each.
uint slab_of(float distance2, uint slab_count) {
    float far = distance2 * frame.tone.z;
    return uint(min(far * sqrt(far), 0.999) * float(slab_count));
}

// Half the sides of the box around the unit disc's preimage, in pixels.
vec2 half_box(vec4 m) {
    float det = m.x * m.w - m.y * m.z;
    return vec2(length(vec2(m.w, m.z)), length(vec2(m.y, m.x))) / abs(det);
}

float radius_of(vec4 m) {
    return inversesqrt(abs(m.x * m.w - m.y * m.z));
}
