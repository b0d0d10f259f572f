#ifndef PICTURE_HALVES_GLSL
#define PICTURE_HALVES_GLSL
// The two halves of a far drop's picture.
#include "appearance.glsl"
#include "pictures.glsl"
#include "shared_exponent.glsl"

// Mean light of both halves of the picture of a direction, whose own mean is theirs. `down`: of the picture's axes.
void picture_halves(uint texel, vec2 down, out vec3 upper, out vec3 lower) {
    const uint EDGE = 4u; // texels of the picture that the halves are means of
    down *= 0.5 * float(EDGE) / max(length(down), 1e-3);
    vec4 above = vec4(0.0), below = vec4(0.0);
    for (uint i = 0u; i < EDGE * EDGE; ++i) {
        vec2 st = (vec2(i % EDGE, i / EDGE) + 0.5) * (2.0 / float(EDGE)) - 1.0;
        // A texel that the line between the halves cuts goes to both by its parts.
        float inside = clamp((1.0 - length(st)) * 0.5 * float(EDGE) + 0.5, 0.0, 1.0);
        float below_line = clamp(dot(st, down) + 0.5, 0.0, 1.0);
        vec4 light = inside * vec4(unpack_radiance(pictures[picture_word(texel, EDGE) + i]), 1.0);
        above += (1.0 - below_line) * light;
        below += below_line * light;
    }
    upper = above.rgb / above.a;
    lower = below.rgb / below.a;
    vec3 share = unpack_radiance(pictures[picture_word(texel, 1u)]) / max(0.5 * (upper + lower), 1e-30);
    upper *= share;
    lower *= share;
}
#endif
