#ifndef SHARED_EXPONENT_GLSL
#define SHARED_EXPONENT_GLSL
// Radiance in one word: three 9-bit mantissas, one 5-bit exponent (as VK_FORMAT_E5B9G9R9). Error:
// 2^-9 of the largest component at most. Range: 0 to 65,408, over that of the stored units.

uint pack_radiance(vec3 c) {
    c = clamp(c, 0.0, 65408.0);
    float most = max(max(c.r, c.g), max(c.b, 1.0 / 32768.0));
    // The exponent that leaves the largest mantissa under 512 after rounding: that of the float rounded to nine bits.
    uint exponent = (floatBitsToUint(most) + 0x4000u) >> 23;
    // 2^(9 - e) and e + 15, where e = exponent - 126.
    uvec3 m = uvec3(c * uintBitsToFloat((262u - exponent) << 23) + 0.5);
    return m.r | (m.g << 9) | (m.b << 18) | ((exponent - 111u) << 27);
}

vec3 unpack_radiance(uint word) {
    // 2^(e - 15 - 9) by its bits.
    float scale = uintBitsToFloat(((word >> 27) + 103u) << 23);
    return vec3(word & 511u, (word >> 9) & 511u, (word >> 18) & 511u) * scale;
}

// What the mantissas of four words are multiplied by.
vec4 scales_of(uvec4 words) {
    return uintBitsToFloat(((words >> 27) + 103u) << 23);
}

// Unpacks four words.
void unpack_radiances(uvec4 words, out vec4 r, out vec4 g, out vec4 b) {
    vec4 scale = scales_of(words);
    r = vec4(words & 511u) * scale;
    g = vec4((words >> 9) & 511u) * scale;
    b = vec4((words >> 18) & 511u) * scale;
}
#endif
