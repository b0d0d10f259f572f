#ifndef ROUNDED_GLSL
#define ROUNDED_GLSL
// The nearest whole number, halves upward. GLSL leaves it to the driver where round() and packUnorm2x16() take halves, and
// llvmpipe takes them elsewhere by vectors that the CPU does not have.
vec2 rounded(vec2 x) {
    precise vec2 above = x + 0.5;
    return floor(above);
}

vec4 rounded(vec4 x) {
    precise vec4 above = x + 0.5;
    return floor(above);
}

// Two shares, from 0 to 1 in 16 bits each.
uint pack_shares(vec2 shares) {
    precise vec2 above = clamp(shares, 0.0, 1.0) * 65535.0 + 0.5;
    uvec2 units = uvec2(above);
    return units.x | units.y << 16;
}

// The bits of the nearest halves, ties to even, of floats from 0 to 65504: fewer steps than a CPU driver's packHalf2x16 takes.
uvec4 half_bits(vec4 x) {
    const float LEAST_NORMAL = 1.0 / 16384.0; // under which a half's last digit is 2^-24, as that of 0.5 is
    uvec4 bits = floatBitsToUint(x), normal = (bits - 0x37fff001u + (bits >> 13 & 1u)) >> 13;
    precise vec4 from_half = x + 0.5;
    return mix(normal, floatBitsToUint(from_half) - floatBitsToUint(0.5), lessThan(x, vec4(LEAST_NORMAL)));
}
#endif
