#ifndef SHAPE_LIGHT_GLSL
#define SHAPE_LIGHT_GLSL
// Radiance that leaves a drop that is no sphere along a ray, traced from surface to surface; the float32 form of
// src/optics/spheroid.rs.
//
// Everything is seen from the middle of the plane that joins the halves, along the world's axes, in radii. A half scaled
// to the unit sphere is met by a quadratic equation (shape_front.glsl); directions and normals stay those of unscaled space.
//
// With the ray go the differentials of two neighbours (Igehy 1999): how far their light fans out is the level at which
// the environment is read, as it is for the sphere in closed form (drop_light.glsl).
#include "drop_light.glsl"
#include "shape_surface.glsl"

// Most surfaces that light is followed to beyond the last order, where that carries what is left and is reflected totally.
const uint MOST_MORE = 16;

// Where a ray is on the surface, its direction after that, and how both change for its two neighbours.
struct Traced {
    vec3 point, direction;
    vec3 point_1, point_2, direction_1, direction_2;
};

// How far two neighbours' directions are apart from a ray's, as one angle.
float fan_of(vec3 first, vec3 second) {
    return sqrt(length(cross(first, second)));
}

// `is_split`: what is seen by the reflection outside and straight through is in `first_map`, else in `map` as well. `to_ray`: from the centre to the ray. `step`: how far rays are apart, in radii.
vec3 shape_light_by_index(bool is_split, sampler2D first_map, sampler2D map, vec4 shape, vec3 to_ray, vec3 d, float step) {
    if (FOOTPRINT == 0u) step = 0.0;
    vec3 p = to_ray - vec3(0.0, shape.w, 0.0), scale = scale_of(shape, upper_met(shape, p, d).x);
    float along;
    Traced t;
    t.point = crossing(p, d, scale, -1.0, along);
    vec3 normal = t.point * scale * scale;
    float gradient = length(normal);
    normal /= gradient;
    float ci = clamp(-dot(d, normal), 1e-4, 1.0), sine2 = max(1.0 - ci * ci, 0.0);
    // Within a sample of the rim the cosine is held at its mean there, else the fan is infinite.
    float held = sqrt(max(ci * ci, min(step, 1.0)));
    vec3 aside = normal + ci * d;
    vec3 e1 = sine2 > 1e-8 ? normalize(aside) : normalize(cross(d, abs(d.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    t.point_1 = e1 + d * (dot(normal, e1) / held);
    t.point_2 = cross(d, e1);
    vec3 normal_1 = bent(normal, scale, gradient, t.point_1), normal_2 = bent(normal, scale, gradient, t.point_2);

    float ct = sqrt(max(1.0 - sine2 / (WATER * WATER), 0.0)), f = reflectance_of(ci, ct, WATER);
    vec3 sum = vec3(0.0);
    if (REFLECTION != 0u) {
        vec3 first = mirrored(d, normal, vec3(0.0), normal_1), second = mirrored(d, normal, vec3(0.0), normal_2);
        float spread = fan_of(first, second) * step;
        vec3 towards = d + 2.0 * ci * normal;
        sum = f * (is_split ? radiance(first_map, towards, spread) : radiance(map, towards, spread));
    }
    float left = 1.0 - f;
    if (left <= 0.0) return sum;
    float ratio = 1.0 / WATER;
    t.direction = normalize(ratio * d + (ratio * ci - ct) * normal);
    t.direction_1 = refracted(d, normal, vec3(0.0), normal_1, ratio, held, max(ct, 1e-3));
    t.direction_2 = refracted(d, normal, vec3(0.0), normal_2, ratio, held, max(ct, 1e-3));

    // What is seen straight through; looked up after the loop, as CPU drivers would do it in each turn.
    vec4 through = vec4(d, 0.0);
    float through_share = 0.0;
    for (uint k = 0u; k <= INTERNAL_REFLECTIONS + MOST_MORE; ++k) {
        vec3 w = t.direction;
        scale = scale_of(shape, upper_met(shape, t.point, w).y);
        vec3 point = crossing(t.point, w, scale, 1.0, along);
        normal = point * scale * scale;
        gradient = length(normal);
        normal /= gradient;
        ci = clamp(dot(w, normal), 1e-4, 1.0);
        vec3 moved_1 = t.point_1 + along * t.direction_1, moved_2 = t.point_2 + along * t.direction_2;
        t.point = point;
        t.point_1 = moved_1 - w * (dot(normal, moved_1) / max(ci, 1e-3));
        t.point_2 = moved_2 - w * (dot(normal, moved_2) / max(ci, 1e-3));
        normal_1 = bent(normal, scale, gradient, t.point_1);
        normal_2 = bent(normal, scale, gradient, t.point_2);

        sine2 = max(1.0 - ci * ci, 0.0) * WATER * WATER;
        ct = sqrt(max(1.0 - sine2, 0.0));
        f = reflectance_of(ci, ct, ratio);
        // Σ over all further orders is what stays inside: the last order takes that as well.
        bool last = k >= INTERNAL_REFLECTIONS || left * f < least_rest(), leaves = f < 1.0;
        float share = CONSERVING != 0u && last ? left : left * (1.0 - f);
        bool ends = last && (leaves || CONSERVING == 0u || k == INTERNAL_REFLECTIONS + MOST_MORE);
        if (leaves || ends && CONSERVING != 0u) {
            vec3 out_direction = leaves ? WATER * w - (WATER * ci - ct) * normal : w;
            vec3 first = refracted(w, -normal, t.direction_1, -normal_1, WATER, ci, max(ct, 1e-3));
            vec3 second = refracted(w, -normal, t.direction_2, -normal_2, WATER, ci, max(ct, 1e-3));
            vec4 seen = vec4(out_direction, fan_of(first, second) * step);
            if (is_split && k == 0u) {
                through = seen;
                through_share = share;
                share = 0.0;
            }
            sum += share * radiance(map, seen.xyz, seen.w);
        }
        if (ends) break;
        left *= f;
        t.direction = normalize(w - 2.0 * ci * normal);
        t.direction_1 = mirrored(w, normal, t.direction_1, normal_1);
        t.direction_2 = mirrored(w, normal, t.direction_2, normal_2);
    }
    return is_split ? sum + through_share * radiance(first_map, through.xyz, through.w) : sum;
}

// Takes each colour by its own index.
vec3 shape_light(bool is_split, sampler2D first_map, sampler2D map, vec4 shape, vec3 to_ray, vec3 d, float step) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < INDICES; ++i) sum += take_index(i) * shape_light_by_index(is_split, first_map, map, shape, to_ray, d, step);
    return sum;
}
#endif
