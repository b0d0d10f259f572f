#ifndef SHARED_HALVES_GLSL
#define SHARED_HALVES_GLSL
// Four halves in two words.
vec4 halves_of(uvec2 word) {
    return vec4(unpackHalf2x16(word.x), unpackHalf2x16(word.y));
}

uvec2 halves(vec4 values) {
    values = min(values, vec4(65504.0));
    return uvec2(packHalf2x16(values.xy), packHalf2x16(values.zw));
}
#endif
