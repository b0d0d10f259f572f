// The order of a tile's drops: by distance, then by index, a total order, so that the picture is the
// same on every run. Needs tile_buffers.glsl and by_four.glsl.

// Of an entry and the one in `place` (squared distance, index, link) the farther stays, the other goes on.
// Unsigned: with signed comparisons llvmpipe 22.3.6 loses entries.
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

// Puts a tile's lists, as the drops came, into one sorted list; returns its first link. From the
// farthest slab on, the eight farthest entries of what is left of its list are picked, in order, and
// put before those that are sorted already. A slab rarely has more, so most lists are read once.
uint order_tile(uint tile) {
    uint sorted = END;
    for (uint slab = SLABS; slab > 0u; --slab) {
        uint link = heads[tile * SLABS + slab - 1u];
        while (link != END) {
            const uvec3 NONE = uvec3(0u, 0u, END);
            // Named one by one: an array that a loop indexes leaves SwiftShader's registers.
            uvec3 a = NONE, b = NONE, c = NONE, d = NONE, e = NONE, f = NONE, g = NONE, h = NONE;
            uint rest = END;
            do {
                uint node = link & ~(NODE - 1u);
                uvec3 entry = uvec3(key_of_node(node), link);
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
            } while (link != END);
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
    }
    return sorted;
}
