#ifndef SHAPE_FRONT_GLSL
#define SHAPE_FRONT_GLSL
// Where a line meets a drop that is no sphere, seen from the middle of the plane that joins its halves, along the world's
// axes, in radii. Which half a line meets follows from where it crosses the joint's plane, so that one equation is solved.
#include "shape.glsl"

// Whether it is the upper half that a line enters, and that it leaves.
bvec2 upper_met(vec4 shape, vec3 p, vec3 d) {
    vec2 at = p.xz * d.y - d.xz * p.y; // where it crosses the plane, times d.y
    float across = shape.x * d.y, side = -dot(d.xz, at);
    bool through = dot(at, at) < across * across;
    return bvec2(through ? d.y < 0.0 : side > 0.0, through ? d.y > 0.0 : side > 0.0);
}

// Reciprocal semi-axes of a half.
vec3 scale_of(vec4 shape, bool upper) {
    float across = 1.0 / shape.x;
    return vec3(across, 1.0 / (upper ? shape.y : shape.z), across);
}

// Where a line enters a scaled half, or leaves it: the point, moved onto the surface so that no rounding adds up.
vec3 crossing(vec3 p, vec3 d, vec3 scale, float side, out float along) {
    vec3 from = p * scale, to = d * scale;
    float a = dot(to, to), nearest = -dot(from, to) / a;
    vec3 middle = from + nearest * to;
    along = nearest + side * sqrt(max(1.0 - dot(middle, middle), 1e-12) / a);
    return normalize(from + along * to) / scale;
}

// How far before the point that is nearest to the centre a ray meets the drop.
float front_of(vec4 shape, vec3 to_ray, vec3 d) {
    vec3 p = to_ray - vec3(0.0, shape.w, 0.0);
    float along;
    crossing(p, d, scale_of(shape, upper_met(shape, p, d).x), -1.0, along);
    return along;
}
#endif
