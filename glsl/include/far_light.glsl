// The mean light of a far drop by its direction. Needs octahedron.glsl, appearance.glsl, sources.glsl, bow.glsl and the
// table `bow`.

#include "source_light.glsl"

// The four texels of an octahedral map about a direction, and how much each counts.
void texels_about(vec3 d, uint edge, out uvec4 texels, out vec4 weights) {
    vec2 at = (0.5 * octahedral(d) + 0.5) * float(edge) - 0.5, from = floor(at), share = at - from;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 weight = mix(1.0 - share, share, vec2(step));
        texels[i] = wrapped_texel(ivec2(from) + step, edge);
        weights[i] = weight.x * weight.y;
    }
}

// Mean light of a far drop in a direction: of the environment without its bright sources between those of the four
// nearest texels; of each source by its angle, and so far as drops are flattened by flat_light.comp.
vec3 far_light(vec3 d) {
    uvec4 texels;
    vec4 weights;
    texels_about(d, DIRECTIONS, texels, weights);
    vec3 sum = light_of_sources(d);
    for (uint i = 0u; i < 4u; ++i) sum += weights[i] * unpack_radiance(pictures[picture_word(texels[i], 1u)]);
    // Where a table of flattened drops begins after those of spheres, if there are any.
    uint flat_from = source_count.x > 0u ? uint(bow[0].w) : 0u;
    if (flat_from == 0u) return sum;
    texels_about(d, FLAT_DIRECTIONS, texels, weights);
    for (uint i = 0u; i < 4u; ++i) sum += weights[i] * bow[flat_from + texels[i]].rgb;
    return sum;
}
