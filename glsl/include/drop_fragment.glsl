#ifndef DROP_FRAGMENT_GLSL
#define DROP_FRAGMENT_GLSL
// What a fragment of a drop has, whatever optics it shows (drops.frag).
#include "environment.glsl"
#include "light_model.glsl"

layout(set = 0, binding = 1) uniform sampler2D environment_map;

layout(location = 0) flat in mat3 rotation; // from the pose of the preprocessing to world space
layout(location = 3) flat in vec3 look;     // mask level, opacity, radius in pixels

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
#endif
