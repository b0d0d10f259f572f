// What the passes of src/passes/tiles.rs and composite.rs hand to each other. Tiles are squares of
// 8 x 8 pixels; a tile's drops lie in 16 slabs by distance.

const uint TILE = 8;
const uint SLABS = 16;
const uint CELLS_A_GROUP = 8; // cells that one workgroup of gather.comp takes on

// A drop in view as its pixels need it.
struct Record {
    vec2 center;    // of its outline, pixels
    float distance2; // squared distance of its centre; infinite: not in view
    uint look;      // number of its direction, 16 bits; opacity, 16 bits
    vec4 to_disc;   // columns of the matrix from pixel offsets to (s, t) of the unit disc
};

// Drop indices, cell by cell; never changes.
layout(std430, set = 0, binding = 1) readonly buffer DropOrder { uint drop_order[]; };
layout(std430, set = 0, binding = 2) readonly buffer CellFirst { uint cell_first[]; };
// First drop, number of drops, first record of each cell in view.
layout(std430, set = 0, binding = 3) buffer VisibleCells { uvec4 visible_cells[]; };
layout(std430, set = 0, binding = 4) buffer Totals {
    uvec4 gather_groups; // of an indirect dispatch
    uvec4 fill_groups;   // of another
    uint visible_cells;
    uint records;
    uint entries;
    uint spare;
} totals;
layout(std430, set = 0, binding = 5) buffer Records { Record records[]; };
// Centre in view space and radius of each record.
layout(std430, set = 0, binding = 6) buffer Spheres { vec4 spheres[]; };
// Index of each record's drop.
layout(std430, set = 0, binding = 7) buffer RecordIndex { uint record_index[]; };
// For each record: first tile (x, y), tiles across and down (0: none) with bit 31 for "wide", and up
// to four places in the lists of the tiles, 16 bits each.
layout(std430, set = 0, binding = 8) buffer Bins { uvec4 bins[]; };
// For each tile and slab: drops of at most 2 x 2 tiles, then wider ones; later, where they begin.
layout(std430, set = 0, binding = 9) buffer SlabSmall { uint slab_small[]; };
layout(std430, set = 0, binding = 10) buffer SlabWide { uint slab_wide[]; };
// For each tile: first entry, number of entries.
layout(std430, set = 0, binding = 11) buffer Tiles { uvec2 tiles[]; };
// Distance (as bits, which sort as the distance does) and record, tile by tile.
layout(std430, set = 0, binding = 12) buffer Entries { uvec2 entries[]; };

// Drops too large for tiles: every tile looks at all of them.
layout(std430, set = 0, binding = 13) buffer Large { vec4 large[]; };
layout(std430, set = 0, binding = 14) buffer LargeIndex { uint large_index[]; };
