#ifndef SPREAD_PICTURE_GLSL
#define SPREAD_PICTURE_GLSL
// The light of a pixel from the picture of a drop that moves or is out of focus.
#include "flattened.glsl"
#include "picture_light.glsl"
#include "picture_turn.glsl"

// The mean light of a picture along a line, in texels from the picture's corner on: of each column (or row, if the line is
// steep) that the line crosses its share, between the two nearest texels.
vec3 picture_along(uint picture, float edge, vec2 first, vec2 last, vec3 turn, Lightened l) {
    bool steep = abs(last.y - first.y) > abs(last.x - first.x);
    vec2 a = clamp(steep ? first.yx : first, 0.0, edge), b = clamp(steep ? last.yx : last, 0.0, edge);
    if (a.x > b.x) { vec2 c = a; a = b; b = c; }
    float length = max(b.x - a.x, 1e-6), slope = (b.y - a.y) / length, end = min(floor(b.x), edge - 1.0);
    vec3 sum = vec3(0.0);
    for (float column = min(floor(a.x), edge - 1.0); column <= end; column += 1.0) {
        float from = max(a.x, column), to = min(b.x, column + 1.0);
        float across = clamp(a.y + slope * (0.5 * (from + to) - a.x) - 0.5, 0.0, edge - 1.0), row = floor(across);
        uvec2 texels = uvec2(steep ? vec2(row, min(row + 1.0, edge - 1.0)) + column * edge
                                   : vec2(row, min(row + 1.0, edge - 1.0)) * edge + column);
        vec3 light = mix(unpack_radiance(picture_at(picture + texels.x)), unpack_radiance(picture_at(picture + texels.y)), across - row);
        vec2 place = ((steep ? vec2(across, column) : vec2(column, across)) + 0.5) * (2.0 / edge) - 1.0;
        sum += max(to - from, 1e-6) * lightened(light, l, from_picture(place, turn));
    }
    return sum / max(length, (end - min(floor(a.x), edge - 1.0) + 1.0) * 1e-6);
}

// How a picture is blurred by a disc and a pixel on the screen.
struct PictureBlur {
    vec3 form;   // squared pixels of a way (s, t) on the drop's disc: form.x s² + 2 form.y s t + form.z t²
    vec2 reach;  // of the blur, texels
    float wide;  // its radius, pixels
    float steep; // how fast a texel leaves it, for each squared pixel of distance
};

// `to_disc`: of pixels, `blur`: the disc's radius in pixels. A disc of radius R has the variance R²/4 along an axis, a pixel's
// square 1/12; a texel, which is a mean itself, a twelfth of its squared side.
PictureBlur picture_blur(vec4 to_disc, float edge, float blur) {
    vec4 m = vec4(to_disc.w, -to_disc.y, -to_disc.z, to_disc.x) / (to_disc.x * to_disc.w - to_disc.y * to_disc.z);
    PictureBlur b;
    b.form = vec3(dot(m.xy, m.xy), dot(m.xy, m.zw), dot(m.zw, m.zw));
    float texel = 2.0 / edge * sqrt(sqrt(max(b.form.x * b.form.z - b.form.y * b.form.y, 0.0)));
    b.wide = sqrt(max(blur * blur + (1.0 - texel * texel) / 3.0, 0.25 * texel * texel));
    b.steep = 0.5 / (b.wide * texel);
    b.reach = 0.5 * edge * (b.wide + 0.5 * texel) * vec2(length(to_disc.xz), length(to_disc.yw));
    return b;
}

// The light of a picture around a place on the drop's disc: what is beyond the rim is not the drop's.
vec3 picture_around(uint picture, float edge, vec2 on_disc, PictureBlur b, vec3 turn) {
    vec2 middle = (0.5 * on_picture(on_disc, turn) + 0.5) * edge;
    // The nearest place on the drop, for a pixel that no texel is near enough to.
    vec2 held = on_disc * min(1.0, inversesqrt(max(dot(on_disc, on_disc), 1e-12)));
    ivec2 nearest = ivec2(clamp((0.5 * on_picture(held, turn) + 0.5) * edge, 0.0, edge - 1.0));
    ivec2 low = min(ivec2(max(middle - b.reach, 0.0)), nearest), high = max(ivec2(min(middle + b.reach, edge - 1.0)), nearest);
    vec4 sum = vec4(0.0);
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            vec2 texel = (vec2(x, y) + 0.5) * (2.0 / edge) - 1.0, way = from_picture(texel, turn) - on_disc;
            float far2 = b.form.x * way.x * way.x + 2.0 * b.form.y * way.x * way.y + b.form.z * way.y * way.y;
            // What parts of the texel are within the blur's disc and on the drop; each in the square of its distance.
            float inside = clamp((b.wide * b.wide - far2) * b.steep + 0.5, 0.0, 1.0);
            float covered = clamp(0.25 * edge * (1.0 - dot(texel, texel)) + 0.5, 0.0, 1.0);
            float weight = inside * covered + (ivec2(x, y) == nearest ? 1e-6 : 0.0);
            vec3 light = unpack_radiance(picture_at(picture + uint(y) * uint(edge) + uint(x)));
            sum += weight * vec4(light, 1.0);
        }
    }
    return sum.rgb / sum.a;
}
#endif
