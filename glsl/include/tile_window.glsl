// A tile's entries, nearest first: its list has them nearly so, as drops come far bands first and larger
// drops, the near ones, last. The nearest of a window of six is taken, the next of the list comes in. Where
// more than that is out of order, or two are equally far, it is known afterwards, and the tile is done again.
// Needs by_four.glsl.

struct Entry {
    float distance2;
    uint place;      // of a splat its centre, from the tile's corner; of a block its node
    uint half_sides; // of a splat; IS_BLOCK; NONE
    uint color;
};
const uint IS_BLOCK = 0xffffffffu, NONE = 0xfffffffeu;
const Entry NO_ENTRY = Entry(3.4e38, 0u, NONE, 0u); // farther than all

Entry read_entry(inout uint link) {
    Entry entry = NO_ENTRY;
    if (link != END) {
        uint node = link & ~(NODE - 1u), which = link & 3u;
        uvec4 words = four_of_nodes(node);
        // The centre from this tile's corner: x and y in halves of the word, in 1/2048 pixel.
        uint x = (words.z - (which & 1u) * (TILE.x * 2048u)) & 0xffffu;
        uint y = (words.z & 0xffff0000u) - (which >> 1) * (TILE.y * 2048u << 16);
        bool block = is_block(link);
        entry.distance2 = uintBitsToFloat(words.x);
        entry.place = block ? node : x | y;
        entry.half_sides = block ? IS_BLOCK : words.w;
        entry.color = words.y;
        link = nodes[link];
    }
    return entry;
}

// Puts the nearer of two first. Word by word: a choice between structs leaves SwiftShader's registers.
void put_in_order(inout Entry a, inout Entry b) {
    bool swap = a.distance2 > b.distance2;
    Entry near = Entry(min(a.distance2, b.distance2), swap ? b.place : a.place,
                       swap ? b.half_sides : a.half_sides, swap ? b.color : a.color);
    b = Entry(max(a.distance2, b.distance2), swap ? a.place : b.place,
              swap ? a.half_sides : b.half_sides, swap ? a.color : b.color);
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
    float before = w.nearest.distance2;
    ++w.taken;
    w.nearest = w.second;
    w.second = w.third;
    w.third = w.fourth;
    w.fourth = w.fifth;
    w.fifth = w.sixth;
    w.sixth = read_entry(w.link);
    let_rise(w);
    w.disordered = w.disordered || w.nearest.distance2 <= before;
}
