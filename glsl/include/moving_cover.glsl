#ifndef MOVING_COVER_GLSL
#define MOVING_COVER_GLSL
// How much a drop with an outline that moves evenly covers of a row of pixels, on the mean, and where in its picture the
// row's colours stand meanwhile. `cover` is for a drop at rest.
#include "projection.glsl"

// The mean of an outline over a longer way is found column by column, over a shorter one by four of its places.
const float STEPS_PX = 4.0;
const uint STEPS = 4;
// Least side of a box that is divided by.
const float LEAST_SIDE = 0.02;

// The integral of two boxes' convolution, of area 1 and middle 0: from -0.5 to 0.5.
vec4 boxes_to(vec4 t, vec4 narrow, vec4 wide) {
    vec4 reach = 0.5 * (narrow + wide), off = min(abs(t), reach), rest = reach - off;
    vec4 slope = 0.5 - rest * rest / (2.0 * narrow * wide);
    return sign(t) * mix(slope, off / wide, lessThan(off, 0.5 * (wide - narrow)));
}

// What an outline at rest covers: its edge is a straight line in each pixel, but for how far it bends over the line's part there. The
// sum over pixels is the outline's area within 1 % from 1.5 pixels of radius on, wherever it lies; by a ramp of one pixel, as
// `cover` has it, within 5 %. `radius`: its mean, pixels.
vec4 cover_at(vec2 from, vec4 to_disc, float radius) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 s = to_disc.x * x + to_disc.z * from.y, t = to_disc.y * x + to_disc.w * from.y;
    vec4 disc = sqrt(s * s + t * t);
    vec4 slope_x = to_disc.x * s + to_disc.y * t, slope_y = to_disc.z * s + to_disc.w * t;
    vec4 inverse = inversesqrt(max(slope_x * slope_x + slope_y * slope_y, 1e-20));
    vec4 inside = (1.0 - disc) * disc * inverse;
    // A pixel's sides along the line's normal: what it is convolved with.
    vec4 sides_x = abs(slope_x) * inverse, sides_y = abs(slope_y) * inverse;
    vec4 wide = max(sides_x, sides_y), narrow = max(min(sides_x, sides_y), LEAST_SIDE);
    vec4 line = clamp((0.5 * (narrow + wide) - abs(inside)) / (narrow * wide), vec4(0.0), 1.0 / wide);
    vec4 covered = 0.5 + boxes_to(inside - line * line / (24.0 * radius), narrow, wide);
    return mix(covered, vec4(1.0), lessThan(disc, vec4(1e-3)));
}

// Twice the integral of a unit disc's half chords.
vec4 chords_to(vec4 m) {
    return m * sqrt(max(1.0 - m * m, 0.0)) + asin(m);
}

// By columns of pixels that lean with the way, seen along its longer axis: what the outline has of one, as a box of its
// mean chord, moves along it. Column and pixel are integrated over, so that the sum over pixels is the outline's area.
vec4 cover_by_columns(vec2 from, vec4 to_disc, vec2 way) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0), y = vec4(from.y);
    bool upright = abs(way.y) >= abs(way.x);
    vec2 turned = upright ? way : way.yx;
    vec4 across = upright ? x : y, along = upright ? y : x;
    float lean = turned.x / turned.y, length = abs(turned.y);
    // The outline's quadratic form, and that of what leans.
    float of_x = dot(to_disc.xy, to_disc.xy), of_both = dot(to_disc.xy, to_disc.zw), of_y = dot(to_disc.zw, to_disc.zw);
    float of_across = upright ? of_x : of_y, of_along = upright ? of_y : of_x;
    float det = of_x * of_y - of_both * of_both;
    float form = of_across * lean * lean + 2.0 * of_both * lean + of_along, half_width = sqrt(form / det);
    // A row leans by so much within itself: of the variance of both.
    float wide = sqrt(half_width * half_width + lean * lean * (1.0 / 3.0)), half_pixel = 0.5 / wide;
    vec4 off = (across - lean * along) / wide;
    vec4 low = clamp(off - half_pixel, -1.0, 1.0), high = clamp(off + half_pixel, -1.0, 1.0);
    vec4 area = (chords_to(high) - chords_to(low)) * inversesqrt(det);
    vec4 chord = max(area / max((high - low) * wide, 1e-6), LEAST_SIDE);
    vec4 place = along + 0.5 * (low + high) * (half_width * (of_across * lean + of_both) / form);
    vec4 narrow = min(chord, length), longer = max(chord, length);
    return area * (boxes_to(place + 0.5, narrow, longer) - boxes_to(place - 0.5, narrow, longer));
}

// When the pixel at (s, t) of the disc is on it, as parts of the exposure from its middle on.
vec2 times_over(vec2 at, vec2 moved) {
    float length2 = max(dot(moved, moved), 1e-12), middle = dot(at, moved) / length2;
    float across = (at.x * moved.y - at.y * moved.x) * inversesqrt(length2);
    float reach = sqrt(max(1.0 - across * across, 0.0) / length2);
    return clamp(vec2(middle - reach, middle + reach), -0.5, 0.5);
}

// The part of those times in which the drop is before what is `far` along the pixel's ray. Its front is taken to be as far before
// its middle as it is on the mean over a disc's chord.
vec2 times_before(vec2 times, vec4 sphere, vec3 motion, vec2 pixel, float far) {
    vec3 d = normalize(ray_through(pixel));
    float rate = dot(d, motion), left = far - dot(d, sphere.xyz) + 0.7 * sphere.w;
    if (abs(rate) < 1e-6 * sphere.w) return left > 0.0 ? times : times.xx;
    float passes = clamp(left / rate, times.x, times.y);
    return rate > 0.0 ? vec2(times.x, passes) : vec2(passes, times.y);
}
#endif
