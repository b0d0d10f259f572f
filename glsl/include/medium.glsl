#ifndef MEDIUM_GLSL
#define MEDIUM_GLSL
// Far rain as a medium (src/rain/medium.rs): it takes light out of a ray and puts in that of a far drop. Drops that are
// shown by themselves have the same mean light, so all of the medium may stand behind them.
// Optical depth from the camera along the view axis, of drops that are seen by an angle to the level of this sine, squared.
// Flattened ones cover the more the steeper they are seen: a spheroid's outline squared is a mean of that seen level and that
// from below.
#include "far_light.glsl"
#include "pcg4d.glsl"
#include "projection.glsl"

float optical_depth(float depth, float sine2) {
    float starts = field.medium.x, at = float(MEDIUM_DEPTHS - 1u) * min(depth / starts, 1.0);
    uint below = min(uint(at), MEDIUM_DEPTHS - 2u), above = below + 1u;
    vec2 low = medium_at(below).xy, high = medium_at(above).xy;
    // Rain without end would be infinitely deep; of this depth nothing passes, and its square is a float.
    vec2 seen = min(mix(low, high, at - float(below)) + field.medium.yw * max(depth - starts, 0.0), 1e6);
    return seen.x == seen.y ? seen.x : sqrt(mix(seen.x * seen.x, seen.y * seen.y, sine2));
}

// Distance to which the medium reaches, as a depth along a unit direction in view space, and optical depth up to there.
vec2 medium_depth(vec3 view, float distance) {
    float cosine = max(-view.z, 1e-6), sine = dot(view, vec3(frame.right.y, frame.up.y, frame.back.y));
    float depth = min(distance, field.medium.z) * cosine;
    return vec2(depth, optical_depth(depth, sine * sine) / cosine);
}

// A number of mean 0 and variance 1 from the lattice of the noise. Between its numbers, which four uniform ones make nearly
// normal, the squares of the weights sum to one.
float grain_at(vec3 world) {
    vec3 place = field.grain_within.xyz + world * field.grain_scale.xyz, from = floor(place), share = place - from;
    uvec4 base = uvec4(field.grain_base.xyz + uvec3(ivec3(from)), field.grain_base.w);
    float sum = 0.0, squares = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, i >> 1 & 1u, i >> 2);
        vec3 weights = mix(1.0 - share, share, vec3(corner));
        float weight = weights.x * weights.y * weights.z;
        sum += weight * (dot(vec4(pcg4d(base + uvec4(corner, 0u))), vec4(1.0 / 4294967296.0)) - 2.0);
        squares += weight * weight;
    }
    return sum * sqrt(3.0 / squares);
}

// Factor on the medium's opacity by the noise of single drops, of mean 1, along a unit direction in view space; `depth`: that
// of `medium_depth`.
float medium_grain(vec3 view, vec3 world, vec2 depth) {
    // So little of the medium that its opacity, which is divided by, rounds to 0 has no noise.
    float passes = exp(-depth.y), opacity = 1.0 - passes;
    if (field.grain_within.w == 0.0 || opacity <= 0.0) return 1.0;
    float at = float(MEDIUM_DEPTHS - 1u) * (1.0 - pow(min(field.grain_within.w / depth.x, 1.0), 1.0 / 3.0));
    uint below = min(uint(at), MEDIUM_DEPTHS - 2u), above = below + 1u;
    float variance = mix(medium_at(below).z, medium_at(above).z, at - float(below));
    // This is the opacity's deviation over its mean.
    float deviation = sqrt(variance) / max(-view.z, 1e-6) * passes / opacity;
    float of_log = log(1.0 + deviation * deviation);
    return exp(sqrt(of_log) * grain_at(world) - 0.5 * of_log);
}

// The share of light that passes the medium, of an optical depth.
float medium_passes(float optical, float grain) {
    return max(1.0 - grain * (1.0 - exp(-optical)), 0.0);
}
#endif
