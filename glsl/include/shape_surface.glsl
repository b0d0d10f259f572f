#ifndef SHAPE_SURFACE_GLSL
#define SHAPE_SURFACE_GLSL
// What the surface of a drop that is no sphere does to a ray, and to the differentials of its neighbours (Igehy 1999).
#include "light_model.glsl"
#include "shape_front.glsl"

// How the unit normal changes where the point does; `gradient`: length of the normal's own before it was made a unit.
vec3 bent(vec3 normal, vec3 scale, float gradient, vec3 moved) {
    vec3 turned = scale * scale * moved;
    return (turned - normal * dot(normal, turned)) / gradient;
}

// Exact, or Schlick's, from the cosines on both sides, of which the first is in the substance before.
float reflectance_of(float cos_incidence, float cos_refraction, float index) {
    if (cos_refraction <= 0.0) return 1.0;
    if (SCHLICK != 0u) {
        float normal = (index - 1.0) / (index + 1.0), x = 1.0 - (index > 1.0 ? cos_incidence : cos_refraction);
        return normal * normal + (1.0 - normal * normal) * (x * x) * (x * x) * x;
    }
    float s = (cos_incidence - index * cos_refraction) / (cos_incidence + index * cos_refraction);
    float p = (index * cos_incidence - cos_refraction) / (index * cos_incidence + cos_refraction);
    return 0.5 * (s * s + p * p);
}

// A direction's change by a reflection on a surface whose normal changes too.
vec3 mirrored(vec3 d, vec3 normal, vec3 d_moved, vec3 normal_moved) {
    float turn = dot(d_moved, normal) + dot(d, normal_moved);
    return d_moved - 2.0 * (turn * normal + dot(d, normal) * normal_moved);
}

// A direction's change by a refraction; the normal is on the ray's side, `ratio` the index before over that beyond.
vec3 refracted(vec3 d, vec3 normal, vec3 d_moved, vec3 normal_moved, float ratio, float cos_in, float cos_out) {
    float turn = -(dot(d_moved, normal) + dot(d, normal_moved));
    float scale = ratio * cos_in - cos_out, scale_moved = (ratio - ratio * ratio * cos_in / cos_out) * turn;
    return ratio * d_moved + scale * normal_moved + scale_moved * normal;
}
#endif
