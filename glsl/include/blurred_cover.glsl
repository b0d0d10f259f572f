#ifndef BLURRED_COVER_GLSL
#define BLURRED_COVER_GLSL
// How much a drop with an outline that is out of focus covers of a row of pixels.
#include "disc.glsl"

// Over so many times the other an overlap's edge is taken for straight: float32 tells its angles no more.
const float STRAIGHT = 4.0;

// What a row's coverage is changed by before it is rounded to units of 1/65535, so that what is faint keeps its light on the
// mean. `first`: the row's first pixel in the picture.
vec4 dithered(vec4 coverage, vec2 first, uint index) {
    float turned = fract(dot(first, vec2(0.75487767, 0.56984029)) + float(index & 0xffffu) * 0.61803399);
    vec4 dither = fract(turned + vec4(0.0, 1.0, 2.0, 3.0) * 0.75487767) - 0.5;
    return mix(vec4(0.0), max(coverage + dither * (1.0 / 65535.0), 0.0), greaterThan(coverage, vec4(0.0)));
}

// `radius`: of the outline, `blur`: of the lens's disc, pixels. The smaller of the two has the pixel in it: the disc of the
// variance of both. Its sum over pixels is the outline's area.
vec4 blurred_cover(vec2 from, vec4 to_disc, float radius, float blur) {
    // Distances as the outline's ellipse has them, and the circle, by what each has of the variance.
    float r2 = radius * radius, all2 = r2 + blur * blur;
    vec3 shape = vec3(dot(to_disc.xy, to_disc.xy), dot(to_disc.xy, to_disc.zw), dot(to_disc.zw, to_disc.zw)) * r2;
    vec3 form = (r2 * shape + blur * blur * vec3(1.0, 0.0, 1.0)) / all2;
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 square = (form.x * x * x + 2.0 * form.y * x * from.y + form.z * from.y * from.y);
    vec4 off = sqrt(square * inversesqrt(max(form.x * form.z - form.y * form.y, 1e-12)));
    float wide = max(radius, blur), narrow = min(radius, blur), top = min(1.0, r2 / (blur * blur));
    float with_pixel = sqrt(narrow * narrow + 1.0 / 3.0), edge = sqrt(3.0 * narrow * narrow + 1.0);
    if (wide > STRAIGHT * with_pixel) {
        return clamp((wide - off) / edge + 0.5, 0.0, 1.0) * (top / (1.0 + edge * edge / (12.0 * wide * wide)));
    }
    return min(overlap(wide, with_pixel, off) * (top / (3.14159265 * with_pixel * with_pixel)), 1.0);
}
#endif
