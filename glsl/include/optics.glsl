#ifndef OPTICS_GLSL
#define OPTICS_GLSL
// One drop in float32; the same as src/optics/mod.rs, which tells the physics.
#include "light_model.glsl"

const bool DISPERSES = INDEX_RED != INDEX_GREEN || INDEX_BLUE != INDEX_GREEN;
const uint INDICES = DISPERSES ? 3u : 1u;

// The index that all below is for.
float WATER = uintBitsToFloat(INDEX_GREEN);

// Takes one of the INDICES, and tells the colours that it is for.
vec3 take_index(uint number) {
    if (!DISPERSES) return vec3(1.0);
    WATER = uintBitsToFloat(number == 0u ? INDEX_RED : number == 1u ? INDEX_GREEN : INDEX_BLUE);
    return vec3(equal(uvec3(number), uvec3(0u, 1u, 2u)));
}

float lowest_index() {
    return min(min(uintBitsToFloat(INDEX_RED), uintBitsToFloat(INDEX_BLUE)), uintBitsToFloat(INDEX_GREEN));
}

float highest_index() {
    return max(max(uintBitsToFloat(INDEX_RED), uintBitsToFloat(INDEX_BLUE)), uintBitsToFloat(INDEX_GREEN));
}

// A ray that meets a drop: unit direction, unit vector from the drop's centre to the ray
// (perpendicular to it), impact parameter b and cos of the incidence angle.
struct Intersection {
    vec3 direction;
    vec3 offset;
    float b;
    float cos_incidence;
};

// 1 where all light is reflected, as at the rim of a bubble.
float sin_refraction(Intersection e) {
    return min(e.b / WATER, 1.0);
}

float cos_refraction(Intersection e) {
    float s = sin_refraction(e);
    return sqrt(1.0 - s * s);
}

// R = (1-2ci²) D + 2 b ci e
vec3 reflected(Intersection e) {
    float ci = e.cos_incidence;
    return (1.0 - 2.0 * ci * ci) * e.direction + 2.0 * e.b * ci * e.offset;
}

// Cos and sin of the deviation δ = 2(θi-θt): the closed form, without trigonometry. Two explicit
// refractions in float32 are 2,500 times less exact at the rim.
vec2 deviation(Intersection e) {
    float ci = e.cos_incidence, ct = cos_refraction(e), st = sin_refraction(e);
    float c = ci * ct + e.b * st, s = e.b * ct - ci * st;
    return vec2(c * c - s * s, 2.0 * c * s);
}

// T = cos δ D - sin δ e
vec3 transmitted(Intersection e) {
    vec2 d = deviation(e);
    return d.x * e.direction - d.y * e.offset;
}

// For unpolarised light; exact, or Schlick's approximation of 1994.
float reflectance(Intersection e) {
    float ci = e.cos_incidence, ct = cos_refraction(e);
    if (SCHLICK != 0u) {
        float normal = (WATER - 1.0) / (WATER + 1.0), x = 1.0 - ci;
        return normal * normal + (1.0 - normal * normal) * (x * x) * (x * x) * x;
    }
    float s = (ci - WATER * ct) / (ci + WATER * ct);
    float p = (WATER * ci - ct) / (WATER * ci + ct);
    return 0.5 * (s * s + p * p);
}

// The mask's texel (s, t) of the level with this half-angle, in the pose of the preprocessing. Sine and
// cosine come from the CPU: a driver's own may be off by 1e-4, which is 0.01° in a direction.
// Beyond the unit disc the rim is continued, so that filtering finds no zeros there.
Intersection mask_intersection(vec2 st, float sin_a, float cos_a) {
    float far = length(st);
    vec2 radial = far > 0.0 ? st / far : vec2(1.0, 0.0);
    float r = min(far, 1.0);
    float norm = sqrt(cos_a * cos_a + r * r * sin_a * sin_a);
    float sin_theta = r * sin_a / norm, cos_theta = cos_a / norm;
    return Intersection(
        vec3(radial * sin_theta, -cos_theta),
        vec3(radial * cos_theta, sin_theta),
        r / norm,
        cos_a * sqrt((1.0 - r) * (1.0 + r)) / norm);
}
#endif
