#ifndef STREAK_LAYER_LINES_GLSL
#define STREAK_LAYER_LINES_GLSL
// The lines that the brightest source draws along wide streaks of the streak layer: while a drop falls, each of its images of the
// source stays at one place of its outline. The two brightest are drawn (lines.comp); other light is spread over the
// streak.
#include "far_glints.glsl"
#include "projection.glsl"
#include "shared_exponent.glsl"
#include "splat_texels.glsl"
#include "tile_buffers.glsl"

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

struct Lines {
    vec2 first, second; // radii from the middle of the drop
    float second_share; // how much of the first one's light the second has
    uint light;         // of the first, packed
};

// Finds the lines of a drop at a pixel of the whole picture. Without an image in it the light is 0.
Lines lines_at(vec2 pixel) {
    vec3 ray = normalize(ray_through(pixel));
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec3 d = world * ray, toward = d;
    uvec4 images = uvec4(0u);
    float brightest = 0.0;
    for (uint i = 0u; i < source_count.x; ++i) {
        uvec4 other = splat_of(ANGLES + i * GLINT_ANGLES + angle_number(dot(d, source_at(i).toward.xyz)));
        float light = dot(unpack_radiance(other.y), LUMINANCE);
        if (light <= brightest) continue;
        brightest = light;
        images = other;
        toward = source_at(i).toward.xyz;
    }
    vec2 on_screen = inversesqrt(max(-ray.z, 1e-3)) * toward_on_screen(ray, toward * world);
    vec2 places = unpackHalf2x16(images.x);
    float share = dot(unpack_radiance(images.z), LUMINANCE) / max(brightest, 1e-30);
    return Lines(places.x * on_screen, places.y * on_screen, share, images.y);
}
#endif
