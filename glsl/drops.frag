#version 460
#extension GL_GOOGLE_include_directive : require
// The paper's section 3.3, fragment half: what a pixel of a drop shows. By the mask; compiled again
// for each other optics, see build/interface.rs.
#include "places.glsl"

layout(constant_id = 8) const uint IS_POINT = 1;
layout(constant_id = 12) const uint SAMPLES = 1;

layout(location = 4) in vec2 corner;
layout(location = 0) out vec4 color;

#if defined(BY_CLOSED_FORM) || defined(DEVIATION_TABLE)
#include "drop_by_ray.glsl"
#elif defined(BY_PICTURE)
#include "drop_by_picture.glsl"
#else
#include "drop_by_mask.glsl"
#endif

void main() {
    vec2 at = IS_POINT != 0u ? gl_PointCoord : corner;
    float across = sqrt(float(SAMPLES)) * look.z;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < SAMPLES; ++i) {
        vec4 found = drop_at(at + (place_of(i, SAMPLES) - 0.5) / (2.0 * look.z), across);
        sum += vec4(found.rgb * found.a, found.a);
    }
    float alpha = sum.a / float(SAMPLES) * look.y;
    if (alpha <= 0.0) discard;
    color = vec4(sum.rgb / sum.a, alpha);
#ifdef STAGE
    if (SHOWN == 0u) color.rgb = vec3(2.0 * look.z * (at - 0.5), look.x);
    if (SHOWN == 1u) color.rgb = transmitted_direction;
#endif
}
