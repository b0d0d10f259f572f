// The order of a tile's drops: by distance, then by index, a total order, so that the picture is the
// same on every run. Needs tile_buffers.glsl and by_four.glsl.

const uint AT_ONCE = 8; // entries sorted in registers

// Puts a tile's lists, as the drops came, into one sorted list; returns its first link. From the
// farthest slab on, the AT_ONCE farthest entries of what is left of its list are picked, in order, and
// put before those that are sorted already. A slab rarely has more, so most lists are read once.
uint order_tile(uint tile) {
    uint sorted = END;
    for (uint slab = SLABS; slab > 0u; --slab) {
        uint link = heads[tile * SLABS + slab - 1u];
        while (link != END) {
            uvec3 farthest[AT_ONCE]; // squared distance, index, link
            for (uint k = 0u; k < AT_ONCE; ++k) farthest[k] = uvec3(0u, 0u, END);
            uint rest = END;
            do {
                uint node = link & ~(NODE - 1u);
                uvec3 entry = uvec3(key_of_node(node), link);
                link = nodes[link];
                for (uint k = 0u; k < AT_ONCE; ++k) {
                    uvec3 other = farthest[k];
                    bool farther = entry.x > other.x || entry.x == other.x && entry.y >= other.y;
                    farthest[k] = farther ? entry : other;
                    entry = farther ? other : entry;
                }
                if (entry.z != END) {
                    nodes[entry.z] = rest;
                    rest = entry.z;
                }
            } while (link != END);
            for (uint k = 0u; k < AT_ONCE; ++k) {
                if (farthest[k].z != END) {
                    nodes[farthest[k].z] = sorted;
                    sorted = farthest[k].z;
                }
            }
            link = rest;
        }
    }
    return sorted;
}
