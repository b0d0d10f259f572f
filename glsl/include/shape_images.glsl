#ifndef SHAPE_IMAGES_GLSL
#define SHAPE_IMAGES_GLSL
// The images of a point of a bright source in a drop that is no sphere: where the drop reflects its light outside towards
// the eye, and where it lets it straight through. Drops of up to 6 mm have one of each, but for those of 4 mm and more
// seen 15° from above: they have a second straight through, with a tenth of the light at most (20,000 rays in 18 views).
//
// All is along the world's axes, from the drop's centre, in radii.
#include "optics.glsl"
#include "shape_surface.glsl"

struct ShapeImage {
    vec3 ray;    // unit vector from the eye
    float light; // over the source's light, a steradian around the eye; 0: there is no image
};

// Where light goes that comes from an eye, and how that changes for two neighbours of a ray, each by a unit angle.
struct Passed {
    vec3 direction, direction_1, direction_2;
    float share; // of the light; 0: the ray misses the drop, or is reflected totally inside
};

// Whether a line through `p` meets the half that it enters.
bool meets(vec3 p, vec3 d, vec3 scale) {
    vec3 from = p * scale, to = d * scale, nearest = from - dot(from, to) / dot(to, to) * to;
    return dot(nearest, nearest) < 1.0;
}

Passed passed_by(bool outside, vec4 shape, vec3 eye, vec3 d, vec3 e1, vec3 e2) {
    Passed passed = Passed(d, e1, e2, 0.0);
    vec3 p = cross(cross(d, eye), d) - vec3(0.0, shape.w, 0.0), scale = scale_of(shape, upper_met(shape, p, d).x);
    if (!meets(p, d, scale)) return passed;
    float along;
    vec3 point = crossing(p, d, scale, -1.0, along), normal = point * scale * scale;
    float gradient = length(normal), far = along - dot(eye, d);
    normal /= gradient;
    float ci = clamp(-dot(d, normal), 1e-4, 1.0);
    vec3 point_1 = far * (e1 + d * (dot(normal, e1) / ci));
    vec3 point_2 = far * (e2 + d * (dot(normal, e2) / ci));
    vec3 normal_1 = bent(normal, scale, gradient, point_1), normal_2 = bent(normal, scale, gradient, point_2);
    float ct = sqrt(max(1.0 - (1.0 - ci * ci) / (WATER * WATER), 0.0)), f = reflectance_of(ci, ct, WATER);
    if (outside) {
        return Passed(d + 2.0 * ci * normal, mirrored(d, normal, e1, normal_1), mirrored(d, normal, e2, normal_2), f);
    }

    float ratio = 1.0 / WATER;
    vec3 w = normalize(ratio * d + (ratio * ci - ct) * normal);
    vec3 w_1 = refracted(d, normal, e1, normal_1, ratio, ci, max(ct, 1e-3));
    vec3 w_2 = refracted(d, normal, e2, normal_2, ratio, ci, max(ct, 1e-3));
    scale = scale_of(shape, upper_met(shape, point, w).y);
    point = crossing(point, w, scale, 1.0, along);
    normal = point * scale * scale;
    gradient = length(normal);
    normal /= gradient;
    ci = clamp(dot(w, normal), 1e-3, 1.0);
    ct = sqrt(max(1.0 - (1.0 - ci * ci) * WATER * WATER, 0.0));
    if (ct == 0.0) return passed;
    point_1 += along * w_1;
    point_2 += along * w_2;
    normal_1 = bent(normal, scale, gradient, point_1 - w * (dot(normal, point_1) / ci));
    normal_2 = bent(normal, scale, gradient, point_2 - w * (dot(normal, point_2) / ci));
    passed.direction = WATER * w - (WATER * ci - ct) * normal;
    passed.direction_1 = refracted(w, -normal, w_1, -normal_1, WATER, ci, max(ct, 1e-3));
    passed.direction_2 = refracted(w, -normal, w_2, -normal_2, WATER, ci, max(ct, 1e-3));
    bool takes_rest = CONSERVING != 0u && INTERNAL_REFLECTIONS == 0u;
    passed.share = (1.0 - f) * (takes_rest ? 1.0 : 1.0 - reflectance_of(ci, ct, ratio));
    return passed;
}

// The ray to where the surface reflects light from `toward`. Its normal halves the two directions, of which the ray's
// follows from the place; each pass is nearer by the drop's size over its distance.
vec3 ray_to_reflection(vec4 shape, vec3 eye, vec3 toward) {
    vec3 d = normalize(-eye);
    for (uint i = 0u; i < 3u; ++i) {
        vec3 normal = normalize(toward - d + vec3(0.0, 1e-6, 0.0));
        float high = normal.y > 0.0 ? shape.y : shape.z;
        vec3 spread = vec3(shape.x * shape.x, high * high, shape.x * shape.x) * normal;
        d = normalize(spread * inversesqrt(dot(normal, spread)) + vec3(0.0, shape.w, 0.0) - eye);
    }
    return d;
}

// The ray to where a far sphere lets light through that comes from `toward`, on the drop's outline (`far_image_of` in
// glints.glsl).
vec3 ray_straight_through(vec4 shape, vec3 eye, vec3 toward) {
    const float AT_RIM = 0.97;
    vec3 axis = normalize(-eye), aside = toward - axis * dot(axis, toward);
    aside *= inversesqrt(max(dot(aside, aside), 1e-12));
    float c = sqrt(max(0.5 + 0.5 * dot(axis, toward), 0.0));
    float apart = 1.0 + WATER * WATER - 2.0 * WATER * c, larger;
    float b = WATER * c > 1.0 ? WATER * sqrt((1.0 - c) * (1.0 + c) / apart) : 1.0;
    return normalize(flattened(shape, -min(b, AT_RIM) * aside, axis, vec3(0.0, 1.0, 0.0), larger) - eye);
}

const uint SHAPE_STEPS = 7; // of Newton's
// Turns of all loops for one image, of which each loop takes one more to end.
const uint SHAPE_TURNS = SHAPE_STEPS + 8;
const float MOST_STEP = 0.5, NEAR_ENOUGH = 1e-3; // radii; radians

// `toward`: unit vector to the point of the source.
ShapeImage image_in_shape(bool outside, vec4 shape, vec3 eye, vec3 toward) {
    if (outside ? REFLECTION == 0u : highest_index() < 1.0) return ShapeImage(toward, 0.0);
    vec3 d = outside ? ray_to_reflection(shape, eye, toward) : ray_straight_through(shape, eye, toward);
    vec3 last = normalize(-eye);
    float light = 0.0, most = MOST_STEP * inversesqrt(dot(eye, eye));
    for (uint i = 0u; i < SHAPE_STEPS; ++i) {
        vec3 e1 = normalize(cross(d, abs(d.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0))), e2 = cross(d, e1);
        Passed passed = passed_by(outside, shape, eye, d, e1, e2);
        light = 0.0;
        if (passed.share > 0.0) {
            float spread = dot(passed.direction, cross(passed.direction_1, passed.direction_2));
            spread = (spread < 0.0 ? -1.0 : 1.0) * max(abs(spread), 1e-6);
            vec3 miss = toward - passed.direction;
            float along_1 = dot(passed.direction, cross(miss, passed.direction_2));
            float along_2 = dot(passed.direction, cross(passed.direction_1, miss));
            vec2 by = vec2(along_1, along_2) / spread;
            last = d;
            if (dot(miss, miss) < NEAR_ENOUGH * NEAR_ENOUGH) light = passed.share / abs(spread);
            by *= min(1.0, most * inversesqrt(max(dot(by, by), 1e-30)));
            d = normalize(d + by.x * e1 + by.y * e2);
        } else {
            d = normalize(d + last);
        }
    }
    return ShapeImage(last, light);
}
#endif
