#ifndef DRAWN_TILES_GLSL
#define DRAWN_TILES_GLSL
// Numbers of the tiles that a frame draws, where they are listed, in four lists: those with several entries; those with one
// splat; with one block; and with none, if they do not show the sky yet. Then for each LISTED_TILES tiles a bit each,
// whether they had entries when they were drawn last.
#include "tile_buffers.glsl"

layout(std430, set = 1, binding = 4) buffer DrawnTiles { uint drawn_tiles[]; };
const uint SEVERAL_ENTRIES = 0, ONE_SPLAT = 1, ONE_BLOCK = 2, SKY_ALONE = 3;

// Two lists share a stretch, one from its first place on, one from its last.
uint listed_at(uint list, uint number) {
    return (list & 1u) == 0u ? (list == SEVERAL_ENTRIES ? number : TILE_COUNT - 1u - number)
        : TILE_COUNT + (list == ONE_SPLAT ? number : TILE_COUNT - 1u - number);
}

uint had_drops(uint word) {
    return 2u * TILE_COUNT + word;
}
#endif
