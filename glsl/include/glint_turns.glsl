#ifndef GLINT_TURNS_GLSL
#define GLINT_TURNS_GLSL
// How many turns of loops a drop's images may take: llvmpipe ends all loops of a vector of invocations after some 65,000, and draws
// nothing more.
#include "glint_spot.glsl"
#include "optics.glsl"
#include "tile_buffers.glsl"

// For a drop at most; for an image at rest; for one that is spread, but for its spots and lines; to look at a source from the lens's edge.
// Measured: at rest llvmpipe ends after 5,785 images.
const uint MOST_TURNS = 60000, TURNS_AT_REST = 12, TURNS_SPREAD = 24, TURNS_TO_LOOK = 1000;
uint turns = 0u;
bool is_over = false;

// Are there as many turns left? All invocations of a workgroup agree. What is over is left out, and counted.
bool take_turns(uint wanted) {
    is_over = is_over || wanted > MOST_TURNS - turns;
    if (!is_over) turns += wanted;
    return !is_over;
}

uint turns_to_find() {
    return is_spread() ? TURNS_SPREAD : TURNS_AT_REST;
}

// Turns to draw an image, by `lanes` invocations: as a line over the pixels that its drop moves by, or as a spot of usual size.
uint turns_to_draw(vec2 way, bool is_blurred, float blur, uint lanes) {
    vec2 tiles = (way + 2.0 * blur) / vec2(TILE);
    return is_blurred ? POINTS + (uint(tiles.y) / lanes + 1u) * (uint(tiles.x) + 2u) : uint(max(way.x, way.y)) / lanes;
}

// Turns to draw an image that an eye sees, and to find how it moves.
uint turns_to_show(uint drop, Eye e, uint lanes) {
    bool is_blurred = HAS_LENS != 0u && moves[2u * drop].w > 0.0;
    float blur = is_blurred ? sqrt(e.part) * moves[2u * drop + 1u].z : 0.0;
    e.way = abs(way_of(drop));
    return turns_to_draw(e.way, is_blurred, blur, lanes) + (moves_otherwise(e) ? 2u * TURNS_SPREAD : 0u);
}

// Turns to look for images of a part of a source, or from an eye, by some `ways`, and to draw them in `draws` each.
uint turns_by(uint ways, uint draws) {
    return 1u + INDICES * uint(bitCount(ways)) * (turns_to_find() + draws);
}

// How many parts or eyes there are turns for, of which each takes `each`; `sources` share the turns that are left.
uint parts_in_time(uint each, uint sources) {
    return max((MOST_TURNS - turns) / sources / each, 1u);
}
#endif
