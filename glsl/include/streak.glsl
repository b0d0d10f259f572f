#ifndef STREAK_GLSL
#define STREAK_GLSL
// How much a small drop covers of each pixel that it passes over, at rest on the mean. See docs/exposure.md.
//
// Seen along the longer axis of its way the drop is a column that leans: across, in a row of pixels, a parabola of the
// outline's variance and of what the row leans by; along, a box whose ends fall over a whole number of pixels. Each has
// the same sum over pixels wherever it lies, so that a streak has the drop's light at every size, length and angle.
#include "tile_buffers.glsl"

struct Streak {
    vec2 center;   // pixels
    float area;    // of the drop, times its opacity, pixels
    bool upright;  // longer along y
    float slope;   // pixels across for one along
    float inverse; // of half its width
    float full;    // length at half its height
    float ends;    // over so many pixels each of its ends falls off
    float blur2;   // squared radius of the disc that a lens spreads it over
};

// `way2`: squared length along the longer axis; `along2`: squared half width of the outline, and of a lens's disc, along it.
void set_length(inout Streak s, float way2, float along2) {
    float all2 = way2 + 3.0 * along2;
    s.ends = max(floor(min(sqrt(1.0 + 3.0 * along2) + 0.5, sqrt(0.5 * (all2 + 1.0)))), 1.0);
    s.full = min(sqrt(max(all2 + 1.0 - s.ends * s.ends, s.ends * s.ends)), 6e4);
}

float inverse_width(float across2, float slope) {
    return min(inversesqrt(1.25 * across2 * (1.0 + slope * slope) + (5.0 / 12.0) * slope * slope), 6e4);
}

// `across2`: squared half width of the outline at right angles to its way; `blur2`: squared radius of the disc that a lens
// spreads it over.
Streak streak_of(vec2 center, vec2 way, float area, float across2, float blur2) {
    Streak s;
    s.center = center;
    s.area = area;
    s.blur2 = blur2;
    s.upright = abs(way.y) >= abs(way.x);
    vec2 turned = s.upright ? way.yx : way;
    s.slope = turned.y / turned.x;
    float stretch2 = 1.0 + s.slope * s.slope, along = abs(turned.x);
    // Variances: a quarter of the squared half width or length of an ellipse, a twelfth of a box's squared length, a
    // fifth of a parabola's.
    s.inverse = inverse_width(across2 + blur2, s.slope);
    set_length(s, along * along, (area * area / (9.8696044 * across2) + blur2) / stretch2);
    return s;
}

// The line that a point of light in the drop draws, `at` radii from its middle, for a light of 1 at a radius of 1 pixel.
Streak line_along(Streak s, vec2 at) {
    s.area *= 1.0 / 3.14159265;
    s.center += sqrt(s.area) * at;
    s.inverse = inverse_width(s.blur2, s.slope);
    float stretch2 = 1.0 + s.slope * s.slope, way2 = s.full * s.full + s.ends * s.ends - 1.0 - 3.0 * (s.area + s.blur2) / stretch2;
    set_length(s, max(way2, 0.0), s.blur2 / stretch2);
    return s;
}

// A streak takes six words, of which only a lens needs the last.
void pack_streak(Streak s, out uvec2 at, out uvec4 rest) {
    at = floatBitsToUint(s.center);
    rest = uvec4(packHalf2x16(vec2(s.slope, s.inverse)), packHalf2x16(vec2(s.full, s.ends)),
                 floatBitsToUint(s.upright ? s.area : -s.area), floatBitsToUint(s.blur2));
}

Streak unpack_streak(uvec2 at, uvec4 rest) {
    vec2 across = unpackHalf2x16(rest.x), along = unpackHalf2x16(rest.y);
    float area = uintBitsToFloat(rest.z);
    return Streak(uintBitsToFloat(at), abs(area), area > 0.0, across.x, across.y, along.x, along.y,
                  HAS_LENS != 0u ? uintBitsToFloat(rest.w) : 0.0);
}

// The integral across of a streak's width, from -0.5 to 0.5.
vec4 width_to(vec4 off) {
    vec4 t = clamp(off, -1.0, 1.0);
    return t * (0.75 - 0.25 * t * t);
}

float width_to(float off) {
    float t = clamp(off, -1.0, 1.0);
    return t * (0.75 - 0.25 * t * t);
}

// What falls on each pixel of a row of four, of which the first's middle is `from`, relative to the streak's.
vec4 streak_share(Streak s, vec2 from) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0), y = vec4(from.y);
    vec4 across = s.upright ? x : y, along = s.upright ? y : x;
    precise vec4 off = (across - s.slope * along) * s.inverse;
    precise vec4 width = width_to(off + 0.5 * s.inverse) - width_to(off - 0.5 * s.inverse);
    precise vec4 length = clamp((0.5 * s.full - abs(along)) / s.ends + 0.5, 0.0, min(s.full / s.ends, 1.0));
    precise vec4 share = width * length * (s.area / s.full);
    return share;
}

// Caps the share, which is coverage then.
vec4 streak_coverage(Streak s, vec2 from) {
    return min(streak_share(s, from), vec4(1.0));
}

// Does the same for an upright streak, whose neighbouring pixels share an edge.
vec4 upright_coverage(Streak s, vec2 from) {
    precise float first = (from.x - 0.5 - s.slope * from.y) * s.inverse;
    precise vec4 off = first + s.inverse * vec4(0.0, 1.0, 2.0, 3.0);
    vec4 edges = width_to(off);
    precise vec4 width = vec4(edges.yzw, width_to(first + 4.0 * s.inverse)) - edges;
    precise float length = clamp((0.5 * s.full - abs(from.y)) / s.ends + 0.5, 0.0, min(s.full / s.ends, 1.0));
    precise float share = length * (s.area / s.full);
    precise vec4 covered = width * share;
    return min(covered, vec4(1.0));
}
#endif
