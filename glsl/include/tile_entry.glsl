// Writes a drop into a place of the list of a tile. Needs tile_buffers.glsl, counters.glsl and the
// constants MAX_ENTRIES and MAX_BLOCKS.

void enter(uint at, uint tile, uint record, float distance2, bool rays) {
    uint what = record_index[record];
    if (rays) {
        uint block = atomicAdd(totals.blocks, 1u);
        what = IS_BLOCK | min(block, MAX_BLOCKS);
        if (block < MAX_BLOCKS) blocks[block] = uvec2(record, tile);
        else atomicAdd(counters.lost, 1u);
    }
    if (at < MAX_ENTRIES) entries[at] = uvec2(floatBitsToUint(distance2), what);
    else atomicAdd(counters.lost, 1u);
}
