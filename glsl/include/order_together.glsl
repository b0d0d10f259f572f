#ifndef ORDER_TOGETHER_GLSL
#define ORDER_TOGETHER_GLSL
// A tile's list put in order by a workgroup, in memory that it shares: on a GPU an invocation alone would wait for each of the reads
// of tile_order.glsl, one after the other.
#include "tile_order.glsl"

const uint SORTING = 64;  // invocations
const uint HELD = 1024;   // entries at most, a power of two; longer lists are put in order by one invocation

shared uvec3 held[HELD];

// By distance and index; those of one drop by link.
bool comes_later(uvec3 a, uvec3 b) {
    return a.x > b.x || a.x == b.x && (a.y > b.y || a.y == b.y && a.z > b.z);
}

// A bitonic sort of so many entries, a power of two.
void sort_held(uint count) {
    for (uint run = 2u; run <= count; run *= 2u) {
        for (uint apart = run / 2u; apart > 0u; apart /= 2u) {
            for (uint i = gl_LocalInvocationID.x; i < count / 2u; i += SORTING) {
                uint low = 2u * i - (i & apart - 1u), high = low + apart;
                uvec3 a = held[low], b = held[high];
                bool swap = comes_later(a, b) == ((low & run) == 0u);
                held[low] = swap ? b : a;
                held[high] = swap ? a : b;
            }
            barrier();
        }
    }
}

// Puts a tile's list of so many entries into order; returns its first link, to the first invocation.
uint order_together(uint tile, uint entries) {
    uint lane = gl_LocalInvocationID.x, link = heads[tile];
    if (entries > HELD) return lane == 0u ? order_tile(tile) : END;
    uint count = 2u << findMSB(max(entries, 2u) - 1u);
    for (uint i = lane; i < count; i += SORTING) held[i] = uvec3(END);
    barrier();
    // All walk, each keeps its own.
    for (uint i = 0u; i < entries && link != END; ++i) {
        if (i % SORTING == lane) held[i] = entry_at(link);
        link = nodes[link];
    }
    barrier();
    sort_held(count);
    // By one, so that it reads what it has written.
    uint sorted = END;
    for (uint i = lane == 0u ? entries : 0u; i > 0u; --i) put_before(sorted, held[i - 1u]);
    return sorted;
}
#endif
