#ifndef MOVING_RAYS_GLSL
#define MOVING_RAYS_GLSL
// The light of a drop that moves, by rays: each meets it for a part of the exposure, in closed form, and follows what it
// shows at one moment of that.
#include "places.glsl"
#include "ray_count.glsl"
#include "ray_in_shape.glsl"
#include "shared_exponent.glsl"

// Fewest rays of a pixel, so that the picture is a mean over time. A drop that covers it for a part o under half of
// the time changes it by o of its colour: 64 o² rays have an eighth of one ray's noise at o = 1. The number is left to chance:
// where the fewest all miss what is bright for a short time, no more follow, and the mean is too dark. With 8, streaks
// of 100 pixels before a bright window were up to 25 of 255 levels too dark over 8 x 8 pixels, with 16 half as much.
const uint LEAST_RAYS = 16 * SURER;

uint rays_of(vec3 d, vec3 motion, float radius) {
    float opacity = min(2.0 * radius / max(length(cross(d, motion)), 1e-30), 0.5);
    return max(SAMPLES, uint(ceil(4.0 * float(LEAST_RAYS) * opacity * opacity)));
}

// How much a pixel's light may be off by chance, of the drop's own, as independent rays would have it. They are spread evenly,
// so that it is a third of this or less. The second: where a pixel has more than one ray at rest.
const float CHANCE = 0.1, LITTLE_CHANCE = 0.04;

// The mean of rays, each with the share that it has of the pixel.
struct Rays {
    vec3 sum;
    float shares, brightness, squares;
};

void add(inout Rays r, vec3 light, float share) {
    r.sum += max(share, 1e-6) * light;
    r.shares += max(share, 1e-6);
    float bright = share * luminance(light);
    r.brightness += bright;
    r.squares += bright * bright;
}

// Whether the mean of so many rays is known well enough.
bool is_known(Rays r, uint count) {
    float n = float(count), mean = r.brightness / n, light = luminance(r.sum) / r.shares;
    float chance = (SAMPLES > 1u ? LITTLE_CHANCE : CHANCE) * light;
    return max(r.squares / n - mean * mean, 0.0) <= chance * chance * n;
}

// Through a flattened drop, rays find the bright sources themselves. A pixel's rays are spread over all that a lens and the drop's way
// bring before it; the environment is blurred by their spacing on this part of that. With less a lamp is missed, or dots in place of
// a line; with all it is up to a quarter too bright.
const float SPREAD = 0.5;

// How far so many rays are apart, in a drop's radii: they are spread over `area` squared pixels, and by lens and way over `beyond`.
float ray_spacing(float area, float beyond, float pixels, uint rays) {
    return clamp(0.25 * pixels, 0.5, 1.0) * sqrt((area + SPREAD * beyond) / float(rays)) / pixels;
}

// Pixels by which a drop moves across a ray.
float way_across(vec3 d, vec3 motion, float radius, float pixels) {
    return pixels / radius * length(cross(d, motion));
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

// What tells a pixel's rays from its neighbours', `moved`: and a drop's from another's. If all pixels took the same moments, the
// picture would be that of those moments.
vec2 turned_of(vec2 corner, vec2 moved) {
    return fract(vec2(dot(corner, vec2(0.75487767, 0.56984029)), dot(corner, vec2(0.81917251, 0.67104361))) + moved);
}

// Does what `color` does, in the pixel from `corner` on; `covered`: part of the time, on the mean over the rays.
uint moving_color(vec2 corner, vec2 low, vec2 high, vec4 sphere, Body body, vec3 motion, float pixels, vec2 moved, float behind, out float covered) {
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec2 extent = high - low, turned = turned_of(corner, moved);
    vec3 middle = normalize(ray_through(0.5 * (low + high)));
    uint least = rays_of(middle, motion, sphere.w), rays = 0u;
    float area = extent.x * extent.y, way = sqrt(area) * way_across(middle, motion, sphere.w, pixels);
    uint apart = max(SAMPLES, least / SURER);
    float step = ray_spacing(area, 0.0, pixels, apart);
    covered = 0.0;
    Rays mean = Rays(vec3(0.0), 0.0, 0.0, 0.0);
    for (; rays < (ARE_FEW ? UNSURE_RAYS : MOST_MOVING_RAYS) && (rays < least || !is_known(mean, rays)); ++rays) {
        vec3 d = normalize(ray_through(low + fract(vec2(0.75487767, 0.56984029) * float(rays) + turned) * extent));
        float nearest;
        vec2 times;
        if (body.is_flat) times = times_met_shape(world * d, world * sphere.xyz, world * motion, sphere.w, body.shape, nearest);
        else times = times_met(d, sphere.xyz, motion, sphere.w, nearest);
        float share = max(times.y - times.x, 0.0);
        // Evenly over the time, in another order than over the pixel: by the golden ratio.
        float moment = share > 0.0 ? mix(times.x, times.y, fract(0.61803399 * float(rays) + turned.y)) : nearest;
        vec3 center = sphere.xyz + moment * motion;
        vec3 to_ray = cross(cross(d, center), d) / -sphere.w;
        float b = length(to_ray), held = min(b, 0.99999);
        vec3 light;
        if (body.is_flat) {
            RayInShape flat_ray = ray_in_shape(body, to_ray, d);
            if (HAS_DEPTH != 0u && dot(d, center) + sphere.w * front_in(flat_ray, body) >= behind) share = 0.0;
            light = light_in(flat_ray, body, world, ray_spacing(area, share * way, pixels, apart), false);
        } else {
            float cosine = sqrt((1.0 - held) * (1.0 + held));
            if (HAS_DEPTH != 0u && dot(d, center) - sphere.w * cosine >= behind) share = 0.0;
            light = drop_light(environment_map, Intersection(d, to_ray / max(b, 1e-9), held, cosine), world, step);
        }
        add(mean, light, share);
        covered += share;
    }
    covered /= float(rays);
    return pack_radiance(mean.sum / mean.shares);
}
#endif
