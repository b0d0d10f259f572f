// A splat in two words: centre in 1/2048 pixel; half sides in 1/512 pixel, and above their bits the number of
// its direction (octahedron.glsl), which tells its colour.
const uint HALF_SIDES_BITS = 20;

uint pack_center(vec2 from_corner) {
    ivec2 at = ivec2(round(clamp(from_corner, -15.9, 15.9) * 2048.0));
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
