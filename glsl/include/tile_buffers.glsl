#ifndef TILE_BUFFERS_GLSL
#define TILE_BUFFERS_GLSL
// What the passes of src/passes/tiles.rs and composite.rs hand to each other. A tile has 4 x 2 pixels:
// so few that one invocation holds them in registers.
//
// CPU drivers run both sides of every branch, every loop once more than it is needed, and pay for
// each word that a lane reads or writes. So the passes are many and each does one thing for every
// lane; what few drops need has passes of its own.

// Set 0 is what all stages of the frame share, declared here and, what other frames have as well, in what is included here.
// Set 1 is a stage's own.

#include "by_texels.glsl"
#include "frame.glsl"
#include "counters.glsl"
#include "large_shape.glsl"
#include "pictures.glsl"
#include "rain_field.glsl"
#include "sources.glsl"

const uvec2 TILE = uvec2(TILE_ACROSS, TILE_DOWN);
const uint PIXELS = TILE.x * TILE.y;
const uint MOST_BIG_GROUPS = 4096; // workgroups of big.comp at most: each gives one drop after the other its blocks
const uint MAX_BINS = MAX_BANDS * MAX_REGIONS;
const uint MOST_TOGETHER = 128; // invocations of the largest subgroup there can be
const uint ROW = 32768; // workgroups of a row, where there may be more than a device takes along an axis

// A pipeline has those of light_model.glsl before.
layout(constant_id = 8) const uint HAS_LENS = 0;     // 1: drops may be seen through a lens
layout(constant_id = 9) const float SPLAT_PX = 1.5; // radius under which a drop is a splat
layout(constant_id = 10) const float RAYS_PX = 12.0; // radius from which it is drawn by rays
layout(constant_id = 11) const uint HAS_PLACED = 0;  // 1: some drops are placed by hand, or drops differ
layout(constant_id = 12) const uint SAMPLES = 1;     // rays a pixel
layout(constant_id = 28) const uint MOST_RAYS = 1;   // of a pixel, where a drop's light changes fast (ray_count.glsl)
layout(constant_id = 35) const uint UNSURE_RAYS = 1; // of one whose light those do not tell
layout(constant_id = 13) const uint HAS_DEPTH = 0;   // 1: what is behind hides drops that are farther (behind.glsl)
layout(constant_id = 14) const uint MOTION = 0;      // 1: the shutter may be open for a time
layout(constant_id = 15) const uint SHAPE = 0;       // what drops are that are no spheres in the scene (shape.glsl)
layout(constant_id = 16) const float FLAT_RAYS_PX = 12.0; // radius from which those are drawn by rays
layout(constant_id = 34) const uint FOR_GPU = 0;     // 1: laid out for a GPU (src/gpu/machine.rs)
layout(constant_id = 22) const uint NEAREST = 0;     // 1: each pixel's nearest drop is wanted (nearest.glsl, drop_records.glsl)
// SHAPE is one of these. Stretched: a sphere's picture on their outline; whole: traced, and rays meet what is around with
// its bright sources, of which some drop may show several images.
const uint SPHERES = 0, STRETCHED = 1, TRACED = 2, WHOLE = 3;

// What depends on the picture's size is no constant, so that pictures of all sizes have the same pipelines.
#define TILE_COUNT frame.tiles.x
#define REGION_SHIFT frame.tiles.y // a region has REGION_ACROSS << this by REGION_DOWN << this tiles
#define REGIONS_ACROSS frame.tiles.z
#define REGIONS frame.tiles.w
#define RAY_PIECE frame.clusters.z // blocks that one dispatch draws by rays, at most
#define MOST_UNFINISHED frame.clusters.w // tiles whose lists take several dispatches, at most
#define MAX_NODES frame.room.x     // splats, and twice the blocks
#define MAX_BLOCKS frame.room.y
#define MAX_LARGES frame.room.z
#define BANDS frame.room.w

// Part of the nodes is the blocks' in any case: they are the nearest drops.
#define MAX_SPLATS (MAX_NODES - MAX_NODES / 16u)

layout(std430, set = 0, binding = 3) buffer Totals {
    uvec4 sort_groups;              // of indirect dispatches: over the clusters in view,
    uvec4 gather_groups[MAX_BANDS]; // over those of a band,
    uvec4 large_groups;             // over the large drops,
    uvec4 big_groups;               // over those of many tiles, one group each,
    uvec4 block_groups;             // over the blocks,
    uvec4 ray_groups[RAY_PIECES];   // over the pixels of blocks drawn by rays, piece after piece (src/passes/pieces.rs),
    uvec4 listed_groups[LISTS];     // over the tiles of drawn_tiles.glsl,
    uvec4 disordered_groups;        // over the disordered tiles
    uvec4 line_groups;              // over the parts of streaks that have lines
    uvec4 shared_groups;            // over the large drops whose glints take a workgroup each
    uvec4 crowded_groups;           // over the crowded tiles, a workgroup each
    uvec4 order_groups;             // over the disordered tiles, a workgroup each
    uvec4 unfinished_groups;        // over the unfinished tiles
    uint larges;
    uint bigs;
    uint blocks;
    uint ray_blocks;
    uint listed[LISTS];             // tiles of drawn_tiles.glsl
    uint disordered;
    uint in_view;                   // clusters
    uint cells_in_view;
    uint streak_links;                // of the streak layer's cells
    uint line_parts;                // parts of its streaks that have lines
    uint shared_drops;              // large drops whose glints take a workgroup each
    uint crowded;                   // tiles that streaks make too long for one invocation (crowded_tile.glsl)
    uint unfinished;                // tiles whose lists take several dispatches (unfinished_tile.glsl)
    uint lacks_room;                // 1: something was lost for which more room can be made
    uint bin_counts[MAX_BINS];      // clusters in view of a band and region: bin band * REGIONS + region
    uint bin_starts[MAX_BINS + MOST_TOGETHER]; // their first place, when they are sorted; beyond the last bin the sum
} totals;
layout(set = 0, binding = 22) uniform usamplerBuffer total_words;
// The word of `totals` with the first of `bin_starts` (src/passes/totals.rs has it as well).
const uint BIN_STARTS = 4u * (10u + MAX_BANDS + RAY_PIECES + LISTS) + LISTS + 13u + MAX_BINS;

uint start_of_bin(uint bin) {
    return BY_TEXELS != 0u ? texelFetch(total_words, int(BIN_STARTS + bin)).x : totals.bin_starts[bin];
}

// Entries of the tiles' lists. From the first place on those of splats, drops so small that two colours
// will do and that touch no more than 2 x 2 tiles, eight words each, with a place for each drop of each cluster in
// view; from the last place on those of blocks, each a tile of a larger drop, sixteen words, a cache line.
//   0  squared distance of the drop's centre, of blocks squared length of its tangents, as bits, which
//      sort as it does
//   1  splat: index of the drop; block: its `number_for_chance`, by which blocks at one distance are in order
//   2  splat: its centre, from the corner of its first tile
//   3  splat: half sides, 20 bits, and number of its direction; block: next in the list
//   4  splat: next in the list of the first tile, 5 of that to the right, 6 and 7 below
//      block: colours of its pixels; 12 what they cover, 16 bits each
// Streaks and discs of one colour are nodes, too, of lists of their own (streak_layer_links.glsl).
// A link is the number of the word that holds the next one. A variable `node` is the number of a node's first word; MAX_NODES and
// records count nodes.
layout(std430, set = 0, binding = 4) buffer Nodes { uint nodes[]; };
layout(std430, set = 0, binding = 4) buffer NodesByFour { uvec4 nodes_by_four[]; };
const uint LINKS = 4, NEXT_OF_BLOCK = 3, COLORS = 4, COVERAGE = 12;
// For each tile the link of its list's first entry, the one that came last.
layout(std430, set = 0, binding = 5) buffer Heads { uint heads[]; };

// A drop of more than a splat as its pixels need it.
struct Large {
    vec4 to_disc;    // columns of the matrix from pixel offsets to (s, t) of the unit disc
    vec4 sphere;     // centre in view space, radius
    vec2 center;     // of its outline, pixels
    uint look;       // number of its direction, 12 bits; BY_RAYS, AS_SPLATS, FLAT; opacity, upper 16 bits
    uint index;      // of the drop; after large.comp its `number_for_chance`
    uint first_tile; // x and y, 16 bits each
    uint across;     // tiles
    uint first_block;
    uint distance2;  // less the squared radius; bits; PLACED_BIT, which no distance has
};
// A drop that is placed, and may so intersect others: blocks.comp orders it by its front.
const uint PLACED_BIT = 0x80000000u;
const uint BY_RAYS = 0x8000u;
// It is a splat's size, but meets three rows of tiles: its one block's place holds the nodes of two splats.
const uint AS_SPLATS = 0x4000u;
// What it covers is found by its rays, too: it comes so near while the shutter is open that it is no outline.
const uint COVER_BY_RAYS = 0x2000u;
// It is no sphere, flat or tall: `large_shapes` (large_shape.glsl) has the rest, and its outline is that of two half ellipses.
const uint FLAT = 0x1000u;
layout(std430, set = 0, binding = 6) buffer Larges { Large larges[]; };
// `large_shapes` has the rest of drops that are FLAT. `moves`, two for each drop where drops may be spread: how it moves in
// view space, and in w the largest disc that a lens makes of a point of it, pixels; how it moves on the screen, and in z that
// disc of its middle. Both are written by large.comp.
#ifndef LARGES_ACCESS
#define LARGES_ACCESS readonly
#endif
layout(std430, set = 0, binding = 7) LARGES_ACCESS buffer Moves { vec4 moves[]; };
layout(std430, set = 0, binding = 10) LARGES_ACCESS buffer LargeShapes { LargeShape large_shapes[]; };
// Number of the large drop of each block; from MAX_BLOCKS on the blocks drawn by rays.
layout(std430, set = 0, binding = 8) buffer Blocks { uint blocks[]; };
// Both for passes that do not write them.
layout(set = 0, binding = 19) uniform usamplerBuffer large_texels;
layout(set = 0, binding = 20) uniform usamplerBuffer block_words;

Large large_at(uint number) {
    if (BY_TEXELS == 0u) return larges[number];
    int at = int(4u * number);
    uvec4 c = texelFetch(large_texels, at + 2), d = texelFetch(large_texels, at + 3);
    return Large(uintBitsToFloat(texelFetch(large_texels, at)), uintBitsToFloat(texelFetch(large_texels, at + 1)),
                 uintBitsToFloat(c.xy), c.z, c.w, d.x, d.y, d.z, d.w);
}

uint large_of_block(uint number) {
    return BY_TEXELS != 0u ? texelFetch(block_words, int(number)).x : blocks[number];
}

// Number of a block that is drawn by rays.
uint ray_block(uint number) {
    return large_of_block(MAX_BLOCKS + number);
}
// How far what is behind the drops is, along the ray through the middle of each pixel: a float a pixel of each tile, which
// sky.comp writes where the background has a depth.
#ifndef BEHIND_ACCESS
#define BEHIND_ACCESS readonly
#endif
layout(std430, set = 0, binding = 12) BEHIND_ACCESS buffer Behind { float distance_behind[]; };
// The lists of streaks (streak_layer.glsl), which gather.comp writes.
#ifndef STREAK_LAYER_ACCESS
#define STREAK_LAYER_ACCESS readonly
#endif
layout(std430, set = 0, binding = 13) STREAK_LAYER_ACCESS buffer StreakLayer { uint streak_layer[]; };
// A far drop's mean light from a source by the angle between them, which bow.comp finds at BOW_ANGLES angles.
layout(std430, set = 0, binding = 15) readonly buffer Bow { vec4 bow[]; };

layout(set = 0, binding = 21) uniform usamplerBuffer source_texels;
Source source_at(uint number) {
    if (BY_TEXELS == 0u) return sources[number];
    int at = int(1u + 2u * number);
    return Source(uintBitsToFloat(texelFetch(source_texels, at)), uintBitsToFloat(texelFetch(source_texels, at + 1)));
}

// Whether drops move in this frame.
bool is_exposed() {
    return MOTION != 0u && frame.moved.w != 0.0;
}

// Whether a drop may be spread over more than its outline in this frame.
bool is_spread() {
    return is_exposed() || HAS_LENS != 0u && frame.lens.x != 0.0;
}

// Number of a workgroup of a dispatch in rows.
uint group_number() {
    return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

// Tiles are told in the whole picture, whichever part of it is drawn: that has those from the first on, and none from
// the end on. Within the whole one more around its own, whose fragments glints.comp asks for their coverage.
uvec2 first_tile() {
    return max(frame.window.xy / TILE, 1u) - 1u;
}

uvec2 end_tile() {
    return min((frame.window.xy + frame.window.zw + TILE - 1u) / TILE + 1u, (uvec2(frame.image.xy) + TILE - 1u) / TILE);
}

uint tiles_across() {
    return end_tile().x - first_tile().x;
}

// Number of a tile of the part that is drawn.
uint tile_number(uvec2 tile) {
    uvec2 at = tile - first_tile();
    return at.y * tiles_across() + at.x;
}

// A region's tiles across and down, and all of them, as powers of two.
uvec2 region_tile_bits() {
    const ivec2 LEAST = findMSB(uvec2(REGION_ACROSS, REGION_DOWN));
    return uvec2(LEAST) + REGION_SHIFT;
}

uint region_bits() {
    return region_tile_bits().x + region_tile_bits().y;
}

// Writes four words of the nodes, from a multiple of four on.
void write_four(uint word, uvec4 four) {
    if (FOR_GPU != 0u) {
        nodes_by_four[word / 4u] = four;
        return;
    }
    nodes[word] = four.x;
    nodes[word + 1u] = four.y;
    nodes[word + 2u] = four.z;
    nodes[word + 3u] = four.w;
}

// First word of the node that holds a link.
uint node_of(uint link) {
    return link & ~(NODE - 1u);
}

// END is no block's.
bool is_block(uint link) {
    return link % NODE == NEXT_OF_BLOCK;
}

// First word of a block's node.
uint block_node(uint number) {
    return (MAX_NODES - 2u * (number + 1u)) * NODE;
}

// Number of the block of a node.
uint block_of_node(uint node) {
    return (MAX_NODES - node / NODE) / 2u - 1u;
}

// Number of a large drop's record (drop_records.glsl): after those of the nodes.
uint large_record(uint number) {
    return MAX_NODES + number;
}

// Blocks that there is room for when the splats have theirs.
uint block_room() {
    uint splats = SPLAT_PX > 0.0 ? min(totals.in_view * CLUSTER, MAX_SPLATS) : 0u;
    return min(MAX_BLOCKS, (MAX_NODES - splats) / 2u);
}

// Has a drop's outline no ellipse, or one that float32 cannot tell? It reaches the camera's plane, or nearly: of
// its centre and its axis, which grow beyond all bounds there, the near edge is the small difference (at 1.01 radii
// by 0.01 pixels, at 1.00001 by eight).
bool is_beside(vec3 view, float radius) {
    return -view.z < 1.01 * radius;
}

// Half the sides of a box of a disc's area, in the shape of the box around its outline.
vec2 box_of_equal_area(vec2 box, float radius) {
    return box * (0.8862269 * radius * inversesqrt(box.x * box.y));
}
#endif
