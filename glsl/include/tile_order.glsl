#ifndef TILE_ORDER_GLSL
#define TILE_ORDER_GLSL
// The order of a tile's drops, where the window of tile_window.glsl does not do: by distance, then by
// index, a total order, so that the picture is the same on every run.
//
// Loops test before each pass, not after it: there llvmpipe 22.3.6 keeps no lane's values that has left before
// the others. And they are few: it stops an invocation's loops, without a word, at 65,535 passes together.
#include "tile_buffers.glsl"

// An entry: squared distance, index, link.
const uvec3 NO_ENTRY_AT = uvec3(0u, 0u, END);
const uint MOST_RUNS = 20; // of 8, 16, 32 … entries

uvec3 entry_at(uint link) {
    uvec3 entry = NO_ENTRY_AT;
    if (link != END) {
        uint node = node_of(link);
        entry = uvec3(nodes[node], nodes[node + 1u], link);
    }
    return entry;
}

bool is_farther(uvec3 a, uvec3 b) {
    return a.x > b.x || a.x == b.x && a.y >= b.y;
}

// The farther of an entry and the one in `place` stays, the other goes on.
void keep_farther(inout uvec3 place, inout uvec3 entry) {
    uvec3 other = place;
    bool farther = is_farther(entry, other);
    place = farther ? entry : other;
    entry = farther ? other : entry;
}

void put_before(inout uint sorted, uvec3 entry) {
    if (entry.z != END) {
        nodes[entry.z] = sorted;
        sorted = entry.z;
    }
}

// The next eight entries of a list as a list in order.
uint take_run(inout uint link) {
    // Named one by one: an array that a loop indexes leaves SwiftShader's registers.
    uvec3 a = NO_ENTRY_AT, b = a, c = a, d = a, e = a, f = a, g = a, h = a;
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 entry = entry_at(link);
        if (link != END) link = nodes[link];
        keep_farther(a, entry);
        keep_farther(b, entry);
        keep_farther(c, entry);
        keep_farther(d, entry);
        keep_farther(e, entry);
        keep_farther(f, entry);
        keep_farther(g, entry);
        keep_farther(h, entry);
    }
    uint run = END;
    put_before(run, a);
    put_before(run, b);
    put_before(run, c);
    put_before(run, d);
    put_before(run, e);
    put_before(run, f);
    put_before(run, g);
    put_before(run, h);
    return run;
}

// Two lists in order, and what they have become so far.
struct Merge {
    uvec3 a, b;       // their nearest entries; END where one has ended
    uint first, last; // of the merged
};

void merge_nearest(inout Merge m) {
    if (m.a.z == END || m.b.z == END) return;
    bool from_b = is_farther(m.a, m.b);
    uint next = from_b ? m.b.z : m.a.z;
    if (m.last == END) m.first = next; else nodes[m.last] = next;
    m.last = next;
    uvec3 following = entry_at(nodes[next]);
    if (from_b) m.b = following; else m.a = following;
}

// Two lists in order as one.
uint merge(uint left, uint right) {
    Merge m = Merge(entry_at(left), entry_at(right), END, END);
    while (m.a.z != END && m.b.z != END) {
        // Four a pass: a list of thousands takes most of its passes here.
        merge_nearest(m);
        merge_nearest(m);
        merge_nearest(m);
        merge_nearest(m);
    }
    uint rest = m.a.z != END ? m.a.z : m.b.z;
    if (m.last == END) m.first = rest; else nodes[m.last] = rest;
    return m.first;
}

// Puts a tile's list into order; returns its first link. Runs of eight are merged as they come, those of
// equal length: n log n passes, so that lists of thousands end.
uint order_tile(uint tile) {
    uint runs[MOST_RUNS], link = heads[tile];
    for (uint i = 0u; i < MOST_RUNS; ++i) runs[i] = END;
    while (link != END) {
        uint run = take_run(link), length = 0u;
        while (length + 1u < MOST_RUNS && runs[length] != END) {
            run = merge(runs[length], run);
            runs[length++] = END;
        }
        runs[length] = merge(runs[length], run);
    }
    uint sorted = END;
    for (uint i = 0u; i < MOST_RUNS; ++i) sorted = merge(runs[i], sorted);
    return sorted;
}
#endif
