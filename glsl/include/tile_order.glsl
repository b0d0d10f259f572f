// The order of a tile's drops, where the window of tile_window.glsl does not do: by distance, then by
// index, a total order, so that the picture is the same on every run. Needs tile_buffers.glsl.

// Of an entry and the one in `place` (squared distance, index, link) the farther stays, the other goes on.
void keep_farther(inout uvec3 place, inout uvec3 entry) {
    uvec3 other = place;
    bool farther = entry.x > other.x || entry.x == other.x && entry.y >= other.y;
    place = farther ? entry : other;
    entry = farther ? other : entry;
}

void put_before(inout uint sorted, uvec3 entry) {
    if (entry.z != END) {
        nodes[entry.z] = sorted;
        sorted = entry.z;
    }
}

// Puts a tile's list into order; returns its first link. The eight farthest entries of what is left are
// picked, in order, and put before those that are sorted already. The loops test before each pass, not after
// it: there llvmpipe 22.3.6 keeps no lane's values that has left before the others.
uint order_tile(uint tile) {
    uint sorted = END, link = heads[tile];
    while (link != END) {
        const uvec3 NO_ENTRY = uvec3(0u, 0u, END);
        // Named one by one: an array that a loop indexes leaves SwiftShader's registers.
        uvec3 a = NO_ENTRY, b = NO_ENTRY, c = NO_ENTRY, d = NO_ENTRY;
        uvec3 e = NO_ENTRY, f = NO_ENTRY, g = NO_ENTRY, h = NO_ENTRY;
        uint rest = END;
        while (link != END) {
            uint node = link & ~(NODE - 1u);
            uint index = is_block(link) ? nodes[node + 1u] : record_index[node / NODE];
            uvec3 entry = uvec3(nodes[node], index, link);
            link = nodes[link];
            keep_farther(a, entry);
            keep_farther(b, entry);
            keep_farther(c, entry);
            keep_farther(d, entry);
            keep_farther(e, entry);
            keep_farther(f, entry);
            keep_farther(g, entry);
            keep_farther(h, entry);
            put_before(rest, entry);
        }
        put_before(sorted, a);
        put_before(sorted, b);
        put_before(sorted, c);
        put_before(sorted, d);
        put_before(sorted, e);
        put_before(sorted, f);
        put_before(sorted, g);
        put_before(sorted, h);
        link = rest;
    }
    return sorted;
}
