// Far rain as a medium (src/rain/medium.rs): it takes light out of a ray and puts in that of a far drop. Drops that are
// shown by themselves have the same mean light, so all of the medium may stand behind them. Needs projection.glsl,
// rain_field.glsl and what far_light.glsl does.
#include "far_light.glsl"

// Optical depth from the camera along the view axis.
float optical_depth(float depth) {
    float starts = field.medium.x, at = 63.0 * min(depth / starts, 1.0);
    uint below = min(uint(at), 62u), above = below + 1u;
    float low = field.depths[below / 4u][below % 4u], high = field.depths[above / 4u][above % 4u];
    return mix(low, high, at - float(below)) + field.medium.y * max(depth - starts, 0.0);
}

// The share of light that passes the medium along a unit direction in view space, up to a distance.
float medium_passes(vec3 view, float distance) {
    float cosine = max(-view.z, 1e-6);
    return exp(-optical_depth(min(distance, field.medium.z) * cosine) / cosine);
}

// What is seen of `behind` through the medium along a unit direction in view space, up to a distance.
vec3 through_medium(vec3 behind, vec3 view, vec3 world, float distance) {
    float passes = medium_passes(view, distance);
    return passes * behind + (1.0 - passes) * far_light(world);
}
