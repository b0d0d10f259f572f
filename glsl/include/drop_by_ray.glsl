#ifndef DROP_BY_RAY_GLSL
#define DROP_BY_RAY_GLSL
// A drop's light along a ray, from the same billboard as the mask's: by the closed form or, where
// DEVIATION_TABLE is defined, from a table over the impact parameter.
#include "drop_fragment.glsl"
#include "optics.glsl"

#ifdef DEVIATION_TABLE
layout(constant_id = 10) const uint INTERVALS = 1;
// Cos of the deviation, its sine over b, reflectance; evenly spaced in cos θi (src/passes/radial.rs).
layout(std430, set = 0, binding = 2) readonly buffer Table { vec4 table[]; };

vec3 tabulated(Intersection e) {
    float at = e.cos_incidence * float(INTERVALS);
    uint below = min(uint(at), INTERVALS - 1u);
    vec3 entry = mix(table[below].xyz, table[below + 1u].xyz, at - float(below));
    return vec3(normalize(vec2(entry.x, entry.y * e.b)), entry.z);
}
#endif
#include "drop_light.glsl"

// Radiance and coverage at `at` of the sprite; `pixels`: its radius in samples.
vec4 drop_at(vec2 at, float pixels) {
    vec2 st = vec2(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
    // The level is that of the distance: tan a = 2^-level.
    float tan_a = exp2(-look.x), cos_a = inversesqrt(1.0 + tan_a * tan_a);
    Intersection e = mask_intersection(st, tan_a * cos_a, cos_a);
    // At the rim itself the fan of directions has no bound.
    e.b = min(e.b, 0.99999);
    e.cos_incidence = max(e.cos_incidence, 4.5e-3);
    return vec4(drop_light(environment_map, e, rotation, 1.0 / pixels), disc_coverage(st, pixels));
}
#endif
