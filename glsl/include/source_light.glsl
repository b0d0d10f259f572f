#ifndef SOURCE_LIGHT_GLSL
#define SOURCE_LIGHT_GLSL
// The light of bright sources in far drops.
#include "tile_buffers.glsl"

// Bright sources, at most (src/passes/glints.rs). Where there are none, no loop over them is compiled: CPU drivers run its body once.
layout(constant_id = 19) const uint GLINTS = 0;

// Mean light of all images of one in a far sphere in a unit direction in world space.
vec3 light_of_source(uint source, vec3 d) {
    vec3 toward = source_at(source).toward.xyz;
    float turn = atan(length(cross(d, toward)), dot(d, toward)) / 3.14159265 * float(BOW_ANGLES - 1u);
    uint below = min(uint(turn), BOW_ANGLES - 2u), entry = source * BOW_ANGLES + below;
    return mix(bow[entry].rgb, bow[entry + 1u].rgb, turn - float(below));
}

// Sums up the light of all sources.
vec3 light_of_sources(vec3 d) {
    vec3 sum = vec3(0.0);
    if (GLINTS == 0u) return sum;
    for (uint i = 0u; i < source_count.x; ++i) sum += light_of_source(i, d);
    return sum;
}
#endif
