#ifndef RAY_IN_SHAPE_GLSL
#define RAY_IN_SHAPE_GLSL
// A ray that meets a drop that is no sphere: where, and what it shows, by SHAPE.
#include "drop_light.glsl"
#include "maps.glsl"
#include "shape_light.glsl"
#include "source_light.glsl"

// What rays need of a drop beside its sphere.
struct Body {
    bool is_flat; // it is no sphere
    vec4 shape;
    bool has_outline;
};

struct RayInShape {
    vec3 direction, to_ray; // view space; from the centre, in radii, held within the rim
    vec3 disc;              // where the outline along the ray is the unit circle
    bool hits;
};

RayInShape ray_in_shape(Body body, vec3 to_ray, vec3 d) {
    vec3 up = vertical(), joint = body.shape.w * (up - dot(d, up) * d);
    vec3 disc = on_disc(body.shape, to_ray, d, up);
    float b = length(disc), inward = min(1.0, 0.99999 / max(b, 1e-9));
    return RayInShape(d, joint + inward * (to_ray - joint), inward * disc, b < 1.0);
}

// How far before its nearest point to the centre it meets the drop, in radii.
float front_in(RayInShape ray, Body body) {
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    return front_of(body.shape, world * ray.to_ray, world * ray.direction);
}

// `by_all`: also bright sources that are reflected outside or come straight through, whose images glints.comp draws else.
vec3 light_in(RayInShape ray, Body body, mat3 world, float step, bool by_all) {
    vec3 to_ray = world * ray.to_ray, d = world * ray.direction;
    bool is_split = SHAPE == TRACED && !by_all && GLINTS != 0u;
    if (SHAPE >= TRACED) return shape_light(is_split, environment_map, whole_map, body.shape, to_ray, d, step);
    float b = length(ray.disc);
    Intersection e = Intersection(ray.direction, ray.disc / max(b, 1e-9), b, sqrt((1.0 - b) * (1.0 + b)));
    return drop_light(environment_map, e, world, step);
}
#endif
