#ifndef DROP_LIGHT_GLSL
#define DROP_LIGHT_GLSL
// Radiance that leaves a drop along a ray, by the closed form: reflection, refraction and internal
// reflections with the Fresnel weights.
// Where DEVIATION_TABLE is defined, deviation and reflectance come from `tabulated` instead.
#include "environment.glsl"
#include "light_model.glsl"
#include "optics.glsl"

// How far directions fan out for a unit step of the impact parameter: the root of the product of
// the radial and the tangential derivative of a deviation whose derivative is `rate`.
float fan(float rate, float sine, float b) {
    return sqrt(abs(rate * sine / max(b, 1e-3)));
}

// Where all further orders together carry less than this share of the light, they are not followed. With 1e-4 that is after two
// or three in the middle of a drop, after eight or more at the rim. See docs/method.md, "How many orders".
float least_rest() { return frame.environment.z; }

// `rotation` takes the ray's vectors to world space. `step`: the impact parameter's change
// over one sample, the reciprocal of the drop's radius in samples.
vec3 drop_light_by_index(sampler2D map, Intersection e, mat3 rotation, float step) {
    float ci = e.cos_incidence, ct = cos_refraction(e), st = sin_refraction(e);
#ifdef DEVIATION_TABLE
    vec3 entry = tabulated(e);
    vec2 deviation = entry.xy;
    float f = entry.z;
#else
    vec2 deviation = deviation(e);
    float f = reflectance(e);
#endif
    if (FOOTPRINT == 0u) step = 0.0;
    // Within a sample of the rim cos θi is held at its mean there, else the fan is infinite.
    float held = sqrt(max(ci * ci, min(step, 1.0)));
    float rate_in = 2.0 / held, rate_turn = 2.0 / (WATER * max(ct, 1e-3));
    vec3 d = rotation * e.direction, o = rotation * e.offset;

    vec3 sum = vec3(0.0);
    // Outside: the fan of a mirror sphere is 2 everywhere.
    if (REFLECTION != 0u) {
        sum = f * radiance(map, (1.0 - 2.0 * ci * ci) * d + 2.0 * e.b * ci * o, 2.0 * step);
    }
    // Each internal reflection turns by π-2θt more.
    vec2 turn = vec2(st * st - ct * ct, 2.0 * st * ct);
    float rate = rate_in - rate_turn;
    float weight = (1.0 - f) * (1.0 - f);
    for (uint k = 0u; k <= INTERNAL_REFLECTIONS; ++k) {
        // Σ_{j≥k} (1-F)² F^j = (1-F) F^k: what the omitted orders carry as well.
        bool last = k == INTERNAL_REFLECTIONS || weight * f < least_rest() * (1.0 - f);
        float share = CONSERVING != 0u && last ? weight / max(1.0 - f, 1e-9) : weight;
        vec3 out_direction = deviation.x * d - deviation.y * o;
        sum += share * radiance(map, out_direction, fan(rate, deviation.y, e.b) * step);
        deviation = vec2(deviation.x * turn.x - deviation.y * turn.y,
                         deviation.y * turn.x + deviation.x * turn.y);
        rate -= rate_turn;
        weight *= f;
        if (last) break;
    }
    return sum;
}

// Takes each colour by its own index.
vec3 drop_light(sampler2D map, Intersection e, mat3 rotation, float step) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < INDICES; ++i) sum += take_index(i) * drop_light_by_index(map, e, rotation, step);
    return sum;
}
#endif
