#ifndef UNFINISHED_TILE_GLSL
#define UNFINISHED_TILE_GLSL
// Tiles whose lists are longer than one dispatch goes through (MOST_ENTRIES), and how far each has come. So every dispatch ends in
// a time that is known before, on any device: a watchdog resets one after two seconds.
#include "composite_tile.glsl"

// Behind the crowded tiles, SAVED vectors for each: its number, how many entries it has taken, whether they came out of order, whether
// it is done; the window; the pixels; their nearest drops. Where there is no room for a tile it stays as far as the first dispatch came.
uvec4 kept(uint at) {
    uint word = 2u * (TILE_COUNT + at);
    return uvec4(disordered_tiles[word], disordered_tiles[word + 1u]);
}

void keep(uint at, uvec4 words) {
    uint word = 2u * (TILE_COUNT + at);
    disordered_tiles[word] = words.xy;
    disordered_tiles[word + 1u] = words.zw;
}

// What a tile has come to.
struct Progress {
    Row upper, lower;
    Window window;
    uint streaks_from; // squared distance, as bits, up to which streaks lie over it
};

// A list is longer than this frame goes through.
void lack_walks() {
    atomicAdd(counters.lost, 1u);
    atomicOr(totals.lacks_room, 1u);
}

void leave_unfinished(uint tile) {
    uint number = atomicAdd(totals.unfinished, 1u);
    if (number < MOST_UNFINISHED) {
        keep(number * SAVED, uvec4(tile, 0u, 0u, 0u));
        atomicMax(totals.unfinished_groups.x, number / 64u + 1u);
    } else {
        lack_walks();
    }
}

void save_row(uint at, Row row, Nearest nearest) {
    keep(at, floatBitsToUint(row.r));
    keep(at + 1u, floatBitsToUint(row.g));
    keep(at + 2u, floatBitsToUint(row.b));
    keep(at + 3u, floatBitsToUint(row.through));
    if (NEAREST == 0u) return;
    keep(at + 4u, nearest.record);
    keep(at + 5u, nearest.count);
}

Row row_at(uint at) {
    return Row(uintBitsToFloat(kept(at)), uintBitsToFloat(kept(at + 1u)), uintBitsToFloat(kept(at + 2u)),
               uintBitsToFloat(kept(at + 3u)));
}

void save(uint at, Progress p) {
    Window w = p.window;
    keep(at + 1u, uvec4(w.nearest.distance2, w.nearest.link, w.second.distance2, w.second.link));
    keep(at + 2u, uvec4(w.third.distance2, w.third.link, w.fourth.distance2, w.fourth.link));
    keep(at + 3u, uvec4(w.fifth.distance2, w.fifth.link, w.sixth.distance2, w.sixth.link));
    keep(at + 4u, uvec4(w.link, p.streaks_from, 0u, 0u));
    save_row(at + 5u, p.upper, upper_nearest);
    save_row(at + 11u, p.lower, lower_nearest);
}

// What was saved; `disordered` as it was.
Progress saved(uint at, bool disordered) {
    uvec4 a = kept(at + 1u), b = kept(at + 2u), c = kept(at + 3u), d = kept(at + 4u);
    Window w = Window(Entry(a.x, a.y), Entry(a.z, a.w), Entry(b.x, b.y), Entry(b.z, b.w), Entry(c.x, c.y), Entry(c.z, c.w), d.x, 0u,
                      disordered);
    if (NEAREST != 0u) {
        upper_nearest = Nearest(kept(at + 9u), kept(at + 10u));
        lower_nearest = Nearest(kept(at + 15u), kept(at + 16u));
    }
    return Progress(row_at(at + 5u), row_at(at + 11u), w, d.y);
}
#endif
