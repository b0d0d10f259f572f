#version 460
#extension GL_GOOGLE_include_directive : require
// The paper's section 3.3, fragment half: what a pixel of a drop shows. By the mask; compiled again
// for each other optics, see build/interface.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "light_model.glsl"
#include "places.glsl"

layout(constant_id = 8) const uint IS_POINT = 1;
layout(constant_id = 12) const uint SAMPLES = 1;

layout(set = 0, binding = 1) uniform sampler2D environment_map;

layout(location = 0) flat in mat3 rotation; // from the pose of the preprocessing to world space
layout(location = 3) flat in vec3 look;     // mask level, opacity, radius in pixels
layout(location = 4) in vec2 corner;
layout(location = 0) out vec4 color;

// Part of a sample that the unit disc covers at `st`: a ramp of one sample across the edge. A drop of
// one pixel has no edge; its disc takes π/4 of its square.
float disc_coverage(vec2 st, float pixels) {
    float ramp = clamp((1.0 - length(st)) * pixels + 0.5, 0.0, 1.0);
    return mix(0.25 * PI, ramp, clamp(2.0 * pixels - 1.0, 0.0, 1.0));
}

#ifdef STAGE
// Which stage of the paper's model is shown instead of its colour: `Stage` in src/renderer/stages.rs.
layout(constant_id = 11) const uint SHOWN = 0;
vec3 transmitted_direction;
#endif

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
