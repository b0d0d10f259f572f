// Far rain as a medium (src/rain/medium.rs): it takes light out of a ray and puts in that of a far drop. Drops that are
// shown by themselves have the same mean light, so all of the medium may stand behind them. Needs projection.glsl,
// rain_field.glsl and what far_light.glsl does.
#include "far_light.glsl"

// Optical depth from the camera along the view axis, of drops that are seen by an angle to the level of this sine, squared.
// Flattened ones cover the more the steeper they are seen: a spheroid's outline squared is a mean of that seen level and that
// from below.
float optical_depth(float depth, float sine2) {
    float starts = field.medium.x, at = 63.0 * min(depth / starts, 1.0);
    uint below = min(uint(at), 62u), above = below + 1u;
    vec2 low = vec2(field.depths[below / 4u][below % 4u], field.from_below[below / 4u][below % 4u]);
    vec2 high = vec2(field.depths[above / 4u][above % 4u], field.from_below[above / 4u][above % 4u]);
    vec2 seen = mix(low, high, at - float(below)) + field.medium.yw * max(depth - starts, 0.0);
    return seen.x == seen.y ? seen.x : sqrt(mix(seen.x * seen.x, seen.y * seen.y, sine2));
}

// The share of light that passes the medium along a unit direction in view space, up to a distance.
float medium_passes(vec3 view, float distance) {
    float cosine = max(-view.z, 1e-6), sine = dot(view, vec3(frame.right.y, frame.up.y, frame.back.y));
    return exp(-optical_depth(min(distance, field.medium.z) * cosine, sine * sine) / cosine);
}

// What is seen of `behind` through the medium along a unit direction in view space, up to a distance.
vec3 through_medium(vec3 behind, vec3 view, vec3 world, float distance) {
    float passes = medium_passes(view, distance);
    return passes * behind + (1.0 - passes) * far_light(world);
}
