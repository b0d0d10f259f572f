#ifndef DROP_BY_PICTURE_GLSL
#define DROP_BY_PICTURE_GLSL
// A drop's light from the prefiltered pictures of a far drop (src/passes/appearance.rs).
#include "drop_fragment.glsl"
#include "octahedron.glsl"
#include "picture_light.glsl"

// Radiance and coverage at `at` of the sprite; `pixels`: its radius in samples.
vec4 drop_at(vec2 at, float pixels) {
    vec2 st = vec2(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
    // The picture of the nearest direction, turned as that direction's basis is.
    uint texel = direction_texel(-rotation[2]);
    vec3 n = texel_direction(texel), u, v;
    basis(n, u, v);
    vec3 place = rotation * vec3(st, 0.0);
    vec2 turned = vec2(dot(place, u), dot(place, v));
    float edge = picture_edge(pixels);
    vec2 at_picture = clamp((0.5 * turned + 0.5) * edge - 0.5, 0.0, edge - 1.0);
    vec3 light = picture_light(picture_word(texel, uint(edge)), edge, picture_steepness(pixels, edge), at_picture);
    return vec4(light, disc_coverage(st, pixels));
}
#endif
