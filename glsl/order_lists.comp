#version 460
#extension GL_GOOGLE_include_directive : require
// Puts the lists of disordered tiles in order, a workgroup a list, in memory that it shares, before composite.comp draws these tiles again.
// On a GPU: an invocation alone would wait for each of the reads of tile_order.glsl, one after the other. See src/passes/composite.rs.
#include "tile_order.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 1, binding = 3) readonly buffer Disordered { uvec2 disordered_tiles[]; };

const uint HELD = 512; // entries at most, a power of two; longer lists are put in order by one invocation

shared uvec3 held[HELD];

// By distance and index; those of one drop by link.
bool comes_later(uvec3 a, uvec3 b) {
    return a.x > b.x || a.x == b.x && (a.y > b.y || a.y == b.y && a.z > b.z);
}

// A bitonic sort of so many entries, a power of two.
void sort_held(uint count) {
    for (uint run = 2u; run <= count; run *= 2u) {
        for (uint apart = run / 2u; apart > 0u; apart /= 2u) {
            for (uint i = gl_LocalInvocationID.x; i < count / 2u; i += gl_WorkGroupSize.x) {
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

void main() {
    uint number = group_number(), lane = gl_LocalInvocationID.x;
    if (number >= totals.disordered) return;
    uint tile = disordered_tiles[number].x, entries = disordered_tiles[number].y, link = heads[tile];
    if (entries > HELD) {
        if (lane == 0u) heads[tile] = order_tile(tile);
        return;
    }
    uint count = 2u << findMSB(max(entries, 2u) - 1u);
    for (uint i = lane; i < count; i += gl_WorkGroupSize.x) held[i] = uvec3(END);
    barrier();
    // All walk, each keeps its own.
    for (uint i = 0u; i < entries && link != END; ++i) {
        if (i % gl_WorkGroupSize.x == lane) held[i] = entry_at(link);
        link = nodes[link];
    }
    barrier();
    sort_held(count);
    for (uint i = lane; i < entries; i += gl_WorkGroupSize.x) nodes[held[i].z] = i + 1u < entries ? held[i + 1u].z : END;
    if (lane == 0u) heads[tile] = held[0].z;
}
