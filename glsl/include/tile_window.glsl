#ifndef TILE_WINDOW_GLSL
#define TILE_WINDOW_GLSL
// A tile's entries, nearest first: its list has them nearly so, as drops come far bands first and larger
// drops, the near ones, last, those that are two splats among them. The nearest of a window of six is taken,
// the next of the list comes in. Where more than that is out of order, or two are equally far, it is known
// afterwards, and the tile is done again.
#include "by_four.glsl"

// What the window holds of an entry is little: all of it takes part in each exchange. Its other words
// are in the cache when its turn comes.
struct Entry {
    uint distance2; // bits
    uint link; // END: none
};
const Entry NO_ENTRY = Entry(0xffffffffu, END); // farther than all

// The entry that a link leads to; the link becomes that to the next.
Entry read_entry(inout uint link) {
    bool ended = link == END;
    uint at = ended ? 0u : link;
    uint distance2 = four_of_nodes(node_of(at)).x;
    uint next = one_of_nodes(at);
    Entry entry = Entry(ended ? NO_ENTRY.distance2 : distance2, link);
    link = ended ? END : next;
    return entry;
}

// Puts the nearer of two first. Word by word: a choice between structs leaves SwiftShader's registers.
void put_in_order(inout Entry a, inout Entry b) {
    bool swap = a.distance2 > b.distance2;
    Entry near = Entry(min(a.distance2, b.distance2), swap ? b.link : a.link);
    b = Entry(max(a.distance2, b.distance2), swap ? a.link : b.link);
    a = near;
}

struct Window {
    Entry nearest, second, third, fourth, fifth, sixth;
    uint link;       // the next of the list
    uint taken;      // entries
    bool disordered; // an entry came too late
};

// Lets the last entry of a window rise to its place among the others, which are in order.
void let_rise(inout Window w) {
    put_in_order(w.fifth, w.sixth);
    put_in_order(w.fourth, w.fifth);
    put_in_order(w.third, w.fourth);
    put_in_order(w.second, w.third);
    put_in_order(w.nearest, w.second);
}

Window open_window(uint link) {
    Window w;
    w.nearest = w.second = w.third = w.fourth = w.fifth = NO_ENTRY;
    w.disordered = false;
    w.taken = 0u;
    for (uint i = 0u; i < 6u; ++i) {
        w.sixth = read_entry(link);
        let_rise(w);
    }
    w.link = link;
    return w;
}

void take_nearest(inout Window w) {
    uint before = w.nearest.distance2;
    if (w.nearest.link != END) ++w.taken;
    w.nearest = w.second;
    w.second = w.third;
    w.third = w.fourth;
    w.fourth = w.fifth;
    w.fifth = w.sixth;
    w.sixth = read_entry(w.link);
    let_rise(w);
    w.disordered = w.disordered || w.nearest.distance2 <= before && w.nearest.link != END;
}
#endif
