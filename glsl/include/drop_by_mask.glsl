#ifndef DROP_BY_MASK_GLSL
#define DROP_BY_MASK_GLSL
// A drop's light by the paper's mask (equation 5): two directions and a reflectance per texel.
#include "drop_fragment.glsl"

layout(set = 0, binding = 2) uniform sampler2DArray mask;

const float WATER = 1.33;

// Radiance and coverage at `at` of the sprite; `pixels`: its radius in samples.
vec4 drop_at(vec2 at, float pixels) {
    vec4 transmission = textureLod(mask, vec3(at, 1.0), look.x);
    vec4 reflection = textureLod(mask, vec3(at, 0.0), look.x);
    vec3 reflected = rotation * normalize(reflection.xyz);
    vec3 transmitted = rotation * normalize(transmission.xyz);
#ifdef STAGE
    transmitted_direction = transmitted;
#endif

    // How far the directions fan out over one pixel: the root of the product of the radial and the
    // tangential derivative. For the reflection that is 2 / R everywhere on the disc; for the
    // refraction √(dδ/db · sin δ / b) / R. Within a pixel of the rim cos θi is held at its mean.
    vec2 st = 2.0 * at - 1.0;
    float b = clamp(length(st), 1e-3, 1.0), bn = b / WATER;
    float ci = sqrt(max(1.0 - b * b, min(1.0 / pixels, 1.0))), ct = sqrt(1.0 - bn * bn);
    float c = ci * ct + b * bn, s = b * ct - ci * bn;
    float fan = 2.0 * (1.0 / ci - 1.0 / (WATER * ct)) * max(2.0 * c * s, 0.0) / b;
    float spread = FOOTPRINT != 0u ? 1.0 / pixels : 0.0;

    float f = reflection.a;
    float through = CONSERVING != 0u ? 1.0 - f : (1.0 - f) * (1.0 - f);
    vec3 light = through * radiance(environment_map, transmitted, sqrt(max(fan, 0.0)) * spread);
    if (REFLECTION != 0u) light += f * radiance(environment_map, reflected, 2.0 * spread);
    return vec4(light, transmission.a);
}
#endif
