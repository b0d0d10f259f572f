#ifndef DISC_GLSL
#define DISC_GLSL
// How much a drop out of focus covers of each pixel: the overlap of its outline and the lens's disc, over that disc.

struct Disc {
    vec2 center;   // pixels
    float radius;  // of the lens's disc, across its way
    float opacity; // in its middle
    vec2 along;    // unit vector of its way
    float longer;  // by what it is longer along that
    float edge;    // pixels over which its edge falls off
};

// A disc takes six words.
void pack_disc(Disc d, out uvec2 at, out uvec4 rest) {
    at = floatBitsToUint(d.center);
    rest = uvec4(packHalf2x16(d.along), packHalf2x16(vec2(min(d.longer, 6e4), min(d.edge, 6e4))),
                 floatBitsToUint(d.opacity), floatBitsToUint(d.radius));
}

Disc unpack_disc(uvec2 at, uvec4 rest) {
    vec2 other = unpackHalf2x16(rest.y);
    return Disc(uintBitsToFloat(at), uintBitsToFloat(rest.w), uintBitsToFloat(rest.z), unpackHalf2x16(rest.x), other.x, other.y);
}

// Coverage of a row of four pixels, of which the first's middle is `from`, relative to the disc's. Its sum over pixels is
// the drop's area; the edge is even where the true one is steepest in its middle (by 0.03 of the opacity).
vec4 disc_coverage(Disc d, vec2 from) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    precise vec4 along = (d.along.x * x + d.along.y * from.y) / d.longer, across = d.along.x * from.y - d.along.y * x;
    precise vec4 off = sqrt(along * along + across * across);
    precise vec4 covered = d.opacity * clamp((d.radius - off) / d.edge + 0.5, 0.0, 1.0);
    return covered;
}

// The overlap of two discs whose middles are `off` apart.
vec4 overlap(float a, float b, vec4 off) {
    vec4 d = clamp(off, abs(a - b) + 1e-4, max(a + b - 1e-4, abs(a - b) + 1e-4));
    vec4 angle_a = acos(clamp((d * d + (a * a - b * b)) / (2.0 * a * d), -1.0, 1.0));
    vec4 angle_b = acos(clamp((d * d + (b * b - a * a)) / (2.0 * b * d), -1.0, 1.0));
    vec4 product = (a + b - d) * (d + a - b) * (d - a + b) * (d + a + b);
    return a * a * angle_a + b * b * angle_b - 0.5 * sqrt(max(product, 0.0));
}
#endif
