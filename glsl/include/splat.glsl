#ifndef SPLAT_GLSL
#define SPLAT_GLSL
// A splat: its node, in two words of which are its centre in 1/2048 pixel; its half sides in 1/512 pixel, and
// above their bits the number of its direction (octahedron.glsl), which tells its colour.
#include "tile_buffers.glsl"
#include "rounded.glsl"

const uint HALF_SIDES_BITS = 20;
const float LONGEST_HALF_SIDE = 1023.0 / 512.0; // pixels; an outline far off the axis may have longer ones

uint pack_center(vec2 from_corner) {
    ivec2 at = ivec2(rounded(clamp(from_corner, -15.9, 15.9) * 2048.0));
    return (uint(at.x) & 0xffffu) | uint(at.y) << 16;
}

vec2 unpack_center(uint word) {
    return vec2(int(word << 16) >> 16, int(word) >> 16) * (1.0 / 2048.0);
}

uint pack_half_sides(vec2 half_sides) {
    uvec2 sides = uvec2(min(half_sides * 512.0 + 0.5, 1023.0));
    return sides.x | sides.y << 10;
}

vec2 unpack_half_sides(uint word) {
    return vec2(word & 1023u, word >> 10 & 1023u) * (1.0 / 512.0);
}

// Where drops are spread (is_spread), y has a bit less, and the last bit tells those that are: their centre is told in 1/128
// pixel, and the root of their opacity in eight bits.
const uint IS_FAINT = 0x80000000u;

uint pack_spread(vec2 from_corner, float opacity) {
    ivec2 fine = ivec2(rounded(clamp(from_corner, vec2(-15.9, -7.9), vec2(15.9, 7.9)) * 2048.0));
    ivec2 coarse = ivec2(rounded(clamp(from_corner, vec2(-15.9, -7.9), vec2(15.9, 7.9)) * 128.0));
    uint root = uint(sqrt(opacity) * 255.0 + 0.5);
    return opacity == 1.0 ? (uint(fine.x) & 0xffffu) | (uint(fine.y) & 0x7fffu) << 16
        : (uint(coarse.x) & 0xfffu) | (uint(coarse.y) & 0x7ffu) << 12 | root << 23 | IS_FAINT;
}

// 1 of those that are not.
float unpack_opacity(uint word) {
    float root = float(word >> 23 & 255u) * (1.0 / 255.0);
    return (word & IS_FAINT) != 0u ? root * root : 1.0;
}

vec2 splat_center(uint word) {
    if (!is_spread()) return unpack_center(word);
    vec2 fine = vec2(int(word << 16) >> 16, int(word << 1) >> 17) * (1.0 / 2048.0);
    vec2 coarse = vec2(int(word << 20) >> 20, int(word << 9) >> 21) * (1.0 / 128.0);
    return (word & IS_FAINT) != 0u ? coarse : fine;
}

// A drop's box and colour, for the tiles from `first` on.
void write_splat(uint node, float distance2, uint index, vec2 center, vec2 half_sides, float opacity, uint direction,
                 uvec2 first) {
    vec2 at = center - vec2(first * TILE);
    uint place = pack_center(at);
    if (is_spread()) {
        place = pack_spread(at, opacity);
        // What the opacity loses by its few bits the sides make up for.
        half_sides *= sqrt(opacity / max(unpack_opacity(place), 1e-9));
    }
    uint look = pack_half_sides(half_sides) | direction << HALF_SIDES_BITS;
    write_four(node, uvec4(floatBitsToUint(distance2), index, place, look));
}

// Pushes a splat to the front of the lists of its tiles that are drawn: 2 x 2 of them from `first` on, but none beyond `last`.
void push_splat(uint node, uvec2 first, uvec2 last) {
    uvec2 low = first_tile(), end = min(last + 1u, end_tile());
    uvec4 next = uvec4(END);
    for (uint i = 0u; i < 4u; ++i) {
        uvec2 tile = first + uvec2(i & 1u, i >> 1);
        if (all(greaterThanEqual(tile, low)) && all(lessThan(tile, end))) {
            uint link = node + LINKS + i;
            next[i] = atomicExchange(heads[tile_number(tile)], link);
            if (FOR_GPU == 0u) nodes[link] = next[i];
        }
    }
    if (FOR_GPU != 0u) write_four(node + LINKS, next);
}
#endif
