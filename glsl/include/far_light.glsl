#ifndef FAR_LIGHT_GLSL
#define FAR_LIGHT_GLSL
// The mean light of a far drop by its direction.
#include "appearance.glsl"
#include "flat_rain.glsl"
#include "flat_suns.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "splat_texels.glsl"
#include "tile_buffers.glsl"

// Number of the texel at a place of the octahedral map, of which one beyond an edge is another within.
uint wrapped_texel(ivec2 at) {
    const int LAST = int(DIRECTIONS) - 1;
    if (at.x < 0 || at.x > LAST) at = ivec2(clamp(at.x, 0, LAST), LAST - at.y);
    if (at.y < 0 || at.y > LAST) at = ivec2(LAST - at.x, clamp(at.y, 0, LAST));
    return uint(at.y) * DIRECTIONS + uint(at.x);
}

// Light of a texel from the environment without its bright sources.
vec3 light_of_texel(uint texel, bool one_by_one) {
    if (!has_flat()) return unpack_radiance(pictures[picture_word(texel, 1u)]);
    uvec2 words = splat_of(flat_rain_entry(texel)).xy;
    return unpack_radiance(one_by_one ? words.y : words.x);
}

// Mean light of a far drop in a direction: of the environment without its bright sources between those of the four
// nearest texels; of each source by its angle, and as flattened drops show it.
vec3 far_light(vec3 d, bool one_by_one) {
    vec2 at = (0.5 * octahedral(d) + 0.5) * float(DIRECTIONS) - 0.5, from = floor(at), share = at - from;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 weights = mix(1.0 - share, share, vec2(step));
        uint texel = wrapped_texel(ivec2(from) + step);
        sum += weights.x * weights.y * light_of_texel(texel, one_by_one);
    }
    if (GLINTS != 0u) {
        for (uint i = 0u; i < source_count.x; ++i) sum += rain_light_of_source(i, d, one_by_one);
    }
    return sum;
}
#endif
