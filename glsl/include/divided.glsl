#ifndef DIVIDED_GLSL
#define DIVIDED_GLSL
// Quotient and remainder of whole numbers whose quotient is under 2^20. CPU drivers divide integers one lane at a time, unless
// they know at compile time by which power of two.
uvec2 divided(uint a, uint b) {
    uint quotient = uint(float(a) / float(b));
    int rest = int(a - quotient * b);
    // Rounding may have made it one too many or too few.
    int off = rest < 0 ? -1 : rest >= int(b) ? 1 : 0;
    return uvec2(quotient + uint(off), uint(rest - off * int(b)));
}
#endif
