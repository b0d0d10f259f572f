#ifndef MOVING_RAYS_GLSL
#define MOVING_RAYS_GLSL
// The light of a drop that moves, by rays: each meets it for a part of the exposure, in closed form, and follows what it
// shows at one moment of that.
#include "places.glsl"
#include "ray_in_shape.glsl"
#include "shared_exponent.glsl"

// Fewest rays of a pixel, so that the picture is a mean over time. A drop that covers it for a part o under half of the time
// changes it by o of its colour: 16 o² rays have a quarter of one ray's noise at o = 1.
const uint LEAST_RAYS = 4;

uint rays_of(vec3 d, vec3 motion, float radius) {
    float opacity = min(2.0 * radius / max(length(cross(d, motion)), 1e-30), 0.5);
    return max(SAMPLES, uint(ceil(4.0 * float(LEAST_RAYS) * opacity * opacity)));
}

// When a ray meets the sphere, as parts of the exposure from its middle on; empty: none. `nearest`: when it is nearest.
vec2 times_met(vec3 d, vec3 center, vec3 motion, float radius, out float nearest) {
    vec3 c = cross(cross(d, center), d), m = cross(cross(d, motion), d);
    float m2 = dot(m, m), r2 = radius * radius;
    vec3 twist = cross(c, m);
    float reach2 = m2 * r2 - dot(twist, twist);
    // Before the camera.
    float start = dot(d, center), slope = dot(d, motion);
    vec2 before = vec2(-0.5, 0.5);
    if (slope > 0.0) before.x = max(before.x, -start / slope);
    if (slope < 0.0) before.y = min(before.y, -start / slope);
    if (slope == 0.0 && start <= 0.0) before = vec2(1.0, 0.0);
    nearest = clamp(m2 > 1e-12 * r2 ? -dot(c, m) / m2 : 0.0, before.x, max(before.x, before.y));
    if (m2 <= 1e-12 * r2) return dot(c, c) < r2 ? before : vec2(1.0, 0.0);
    if (reach2 <= 0.0) return vec2(1.0, 0.0);
    float middle = -dot(c, m) / m2, reach = sqrt(reach2) / m2;
    return vec2(max(middle - reach, before.x), min(middle + reach, before.y));
}

// When a ray meets a drop that is no sphere, along the world's axes. Each half is scaled to a unit sphere; what a ray meets of a
// convex body is one stretch of time, whose ends are those of the half that is met then.
vec2 times_met_shape(vec3 d, vec3 center, vec3 motion, float radius, vec4 shape, out float nearest) {
    const vec3 up = vec3(0.0, 1.0, 0.0);
    vec3 joint = center + shape.w * radius * up;
    float unused;
    vec3 scale = scale_of(shape, true) / radius;
    vec2 upper = times_met(normalize(d * scale), joint * scale, motion * scale, 1.0, nearest);
    if (shape.y == shape.z) return upper;
    scale = scale_of(shape, false) / radius;
    vec2 lower = times_met(normalize(d * scale), joint * scale, motion * scale, 1.0, unused);
    // The ray is over the joint where its offset from that is.
    float sine = d.y, at = sine * dot(joint, d) - joint.y, rate = sine * dot(motion, d) - motion.y;
    bvec2 over = greaterThan(at + rate * upper, vec2(0.0)), under = lessThanEqual(at + rate * lower, vec2(0.0));
    bool upper_meets = upper.x <= upper.y, lower_meets = lower.x <= lower.y;
    vec2 times = vec2(1.0, 0.0);
    if (upper_meets && over.x) times.x = upper.x; else if (lower_meets && under.x) times.x = lower.x; else return times;
    if (upper_meets && over.y) times.y = upper.y; else if (lower_meets && under.y) times.y = lower.y; else return vec2(1.0, 0.0);
    return times;
}

// Does what `color` does; `covered`: part of the time, on the mean over the rays.
uint moving_color(vec2 low, vec2 high, vec4 sphere, Body body, vec3 motion, float pixels, vec2 moved, float behind, out float covered) {
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec2 extent = high - low;
    uint rays = rays_of(normalize(ray_through(0.5 * (low + high))), motion, sphere.w);
    float step = clamp(0.25 * pixels, 0.5, 1.0) * sqrt(extent.x * extent.y / float(rays)) / pixels;
    covered = 0.0;
    for (uint i = 0u; i < rays; ++i) {
        vec3 d = normalize(ray_through(low + fract(place_of(i, rays) + moved) * extent));
        float nearest;
        vec2 times;
        if (body.is_flat) times = times_met_shape(world * d, world * sphere.xyz, world * motion, sphere.w, body.shape, nearest);
        else times = times_met(d, sphere.xyz, motion, sphere.w, nearest);
        float share = max(times.y - times.x, 0.0);
        // Evenly over the time, in another order than over the pixel: by the golden ratio.
        float moment = share > 0.0 ? mix(times.x, times.y, fract(0.61803399 * float(i) + moved.x)) : nearest;
        vec3 center = sphere.xyz + moment * motion;
        vec3 to_ray = cross(cross(d, center), d) / -sphere.w;
        float b = length(to_ray), held = min(b, 0.99999);
        if (body.is_flat) {
            RayInShape flat_ray = ray_in_shape(body, to_ray, d);
            if (HAS_DEPTH != 0u && dot(d, center) + sphere.w * front_in(flat_ray, body) >= behind) share = 0.0;
            float weight = max(share, 1e-6);
            sum += weight * light_in(flat_ray, body, world, step);
            weights += weight;
            covered += share;
            continue;
        }
        if (HAS_DEPTH != 0u && dot(d, center) - sphere.w * sqrt((1.0 - held) * (1.0 + held)) >= behind) share = 0.0;
        float weight = max(share, 1e-6);
        Intersection e = Intersection(d, to_ray / max(b, 1e-9), held, sqrt((1.0 - held) * (1.0 + held)));
        sum += weight * drop_light(environment_map, e, world, step);
        weights += weight;
        covered += share;
    }
    covered /= float(rays);
    return pack_radiance(sum / weights);
}
#endif
