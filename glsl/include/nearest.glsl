#ifndef NEAREST_GLSL
#define NEAREST_GLSL
// For each pixel of a tile the nearest drop that covers a part of it, and how many do, while its drops are taken front to
// back.
#include "appearance.glsl"
#include "tile_buffers.glsl"

// Two words a pixel, row by row: number of the nearest drop's record (drop_records.glsl), END: none; drops that cover a
// part of the pixel.
layout(std430, set = 1, binding = 8) writeonly buffer NearestDrops { uvec2 nearest_drops[]; };

// Holds both for a row of a tile's pixels.
struct Nearest {
    uvec4 record, count;
};
const Nearest NONE_MET = Nearest(uvec4(END), uvec4(0u));

bvec4 both(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) & uvec4(b));
}

// Which pixels of a row of a block have a part of the drop: it is covered, and has a colour.
bvec4 met_by_block(uvec2 coverage, uvec4 colors) {
    uvec4 parts = uvec4(coverage.x & 0xffffu, coverage.x >> 16, coverage.y & 0xffffu, coverage.y >> 16);
    return both(notEqual(parts, uvec4(0u)), notEqual(colors, uvec4(NO_COLOR)));
}

// The next drop, which covers a part of some pixels.
void meet(inout Nearest row, bvec4 met, uint record) {
    row.record = mix(row.record, uvec4(record), both(met, equal(row.count, uvec4(0u))));
    row.count += uvec4(met);
}
#endif
