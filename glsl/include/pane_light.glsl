#ifndef PANE_LIGHT_GLSL
#define PANE_LIGHT_GLSL
// The light that comes through a pane along a ray. It is followed from surface to surface: src/reference/pane.rs tells the physics.
//
// The tangential part of a ray's direction times the index is the same in air, glass and water. So no direction depends on the
// glass, and a drop's first exit has a closed form (src/optics/cap.rs).
#include "pane.glsl"
#include "pane_drops.glsl"
#include "environment.glsl"

layout(set = 0, binding = 6) uniform sampler2D environment_map;
// A picture behind the drops, a texel a pixel of the whole.
layout(set = 0, binding = 7) uniform sampler2D plate_image;

// Light under this share of a ray's is not followed; by models picture and color, under the second.
const float FAINT = 1e-6, FAINT_BY_LOOKS = 5e-3;

// The plate at a place of the picture, bilinear by hand: not every device filters float32.
vec3 plate_at(vec2 pixel) {
    ivec2 last = textureSize(plate_image, 0) - 1;
    vec2 at = clamp(pixel - 0.5, vec2(0.0), vec2(last)), share = fract(at);
    ivec2 first = ivec2(at), next = min(first + 1, last);
    vec3 upper = mix(texelFetch(plate_image, first, 0).rgb, texelFetch(plate_image, ivec2(next.x, first.y), 0).rgb, share.x);
    vec3 lower = mix(texelFetch(plate_image, ivec2(first.x, next.y), 0).rgb, texelFetch(plate_image, next, 0).rgb, share.x);
    return pane.plate * mix(upper, lower, share.y);
}

// Radiance from a direction outside: the plate where it is in the picture, else the environment, blurred by `spread` radians.
vec3 outside_of(vec3 d, float spread) {
    vec3 view = d.x * pane.u + d.y * pane.v + d.z * pane.normal;
    if (pane.plate > 0.0 && view.z < 0.0) {
        vec2 pixel = pixel_of(frame.image.z / -view.z * vec2(view.x, -view.y));
        if (all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThanEqual(pixel, frame.image.xy))) return plate_at(pixel);
    }
    return radiance(environment_map, mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * view, spread);
}

// What a ray through a drop sees. By models picture and color its sky is looked up once, in the direction in which it sees most of it: of
// the few percent that leave elsewhere most sees the inside.
struct Light {
    vec3 sky;
    float inside;     // share that sees the inside
    vec3 direction;   // in which the most is seen
    float most, share;
};

// Adds what leaves in a direction: `weight` of the ray's light, of which `share` sees the sky, by way of the dry pane if it leaves towards
// that, and the rest the inside.
void add_exit(inout Light l, vec3 d, float weight, float share, float spread) {
    if (d.z <= 0.0) share *= 1.0 - dry_pane(-d.z);
    float sky = weight * share;
    l.inside += weight - sky;
    d.z = abs(d.z);
    if (PANE_MODEL == 0u) {
        l.sky += sky * outside_of(d, spread);
    } else {
        l.direction = sky > l.most ? d : l.direction;
        l.most = max(l.most, sky);
        l.share += sky;
    }
}

// What of a ray's light leaves the water where it meets a surface, and where to.
struct Exit {
    vec3 direction;
    float reflectance;
    float share; // of what leaves that sees the sky; the rest sees the inside
};

// `tangent`: of the unit direction in water along the surface, times the index.
Exit exit_by_cap(vec3 tangent, vec3 normal, float cosine, float water) {
    float out2 = 1.0 - dot(tangent, tangent), far = sqrt(max(out2, 0.0));
    return Exit(tangent + far * normal, out2 > 0.0 ? pane_fresnel(cosine, far, 1.0 / water) : 1.0, 1.0);
}

// Into the glass: caught there, or F/(1+F) comes back out beside the drop.
Exit exit_by_base(vec3 tangent, float cosine, float water) {
    float along2 = dot(tangent.xy, tangent.xy), out2 = 1.0 - along2, glass2 = pane.glass * pane.glass - along2;
    float far = sqrt(max(out2, 0.0)), in_glass = sqrt(max(glass2, 0.0)) / pane.glass;
    float dry = pane_fresnel(far, in_glass, pane.glass);
    float reflectance = glass2 > 0.0 ? pane_fresnel(cosine, in_glass, pane.glass / water) : 1.0;
    return Exit(vec3(tangent.xy, far), reflectance, out2 > 0.0 ? dry / (1.0 + dry) : 0.0);
}

// Adds what arrives in the water of a drop at a place, from its disc's middle on, where `left` of a ray goes on along a unit direction.
void add_from_water(inout Light l, PaneCap cap, vec3 place, bool on_cap, vec3 d, float left, float water, float spread) {
    vec3 center = vec3(0.0, 0.0, cap.center);
    float least = PANE_MODEL == 0u ? FAINT : FAINT_BY_LOOKS;
    for (uint i = 0u; i <= PANE_REFLECTIONS && left > least; ++i) {
        vec3 from = place - center;
        float b = dot(from, d);
        // By the distance from the disc's rim nothing cancels: both squares of the sphere's radius are left out.
        float within = on_cap ? 0.0 : dot(place.xy, place.xy) - cap.radius * cap.radius;
        float to_cap = max(sqrt(max(b * b - within, 0.0)) - b, 0.0), to_base = d.z < 0.0 ? -place.z / d.z : NOWHERE;
        on_cap = to_cap <= to_base;
        place += min(to_cap, to_base) * d;
        vec3 normal = on_cap ? normalize(place - center) : vec3(0.0, 0.0, -1.0);
        if (on_cap) place = center + cap.sphere * normal; else place.z = 0.0;
        float cosine = clamp(dot(d, normal), 0.0, 1.0);
        vec3 tangent = water * (d - dot(d, normal) * normal);
        Exit e = exit_by_base(tangent, cosine, water);
        if (on_cap) e = exit_by_cap(tangent, normal, cosine, water);
        if (e.reflectance < 1.0) add_exit(l, e.direction, left * (1.0 - e.reflectance), e.share, spread);
        left *= e.reflectance;
        d = normalize(d - 2.0 * dot(d, normal) * normal);
    }
}

// What a ray sees that meets a drop at a place, from its disc's middle on: through the disc, or from outside.
vec3 light_of_drop(PaneCap cap, vec3 place, bool outside, vec3 d, float water, float spread) {
    float in_glass = cosine_in(d.z, pane.glass), in_water = cosine_in(d.z, water);
    float enters = (1.0 - pane_fresnel(d.z, in_glass, pane.glass)) * (1.0 - pane_fresnel(in_glass, in_water, water / pane.glass));
    vec3 into = vec3(d.xy / water, in_water), reflected = vec3(0.0, 0.0, 1.0);
    if (outside) {
        vec3 normal = normalize(place - vec3(0.0, 0.0, cap.center));
        float cosine = clamp(-dot(d, normal), 0.0, 1.0), far = cosine_in(cosine, water);
        enters = 1.0 - pane_fresnel(cosine, far, water);
        into = normalize((d + cosine * normal) / water - far * normal);
        reflected = d + 2.0 * cosine * normal;
    }
    Light l = Light(vec3(0.0), 0.0, vec3(0.0, 0.0, 1.0), 0.0, 0.0);
    add_exit(l, reflected, 1.0 - enters, outside ? 1.0 : 0.0, spread);
    add_from_water(l, cap, place, outside, into, enters, water, spread);
    if (PANE_MODEL != 0u) l.sky = l.share * outside_of(l.direction, spread);
    return l.sky + l.inside * pane.inside;
}

// What a ray sees at the pane, what share of it goes on beyond, and the drop that it has met.
struct Passed {
    vec3 light;
    float left;
    uint cap;
};

// `spacing`: of rays on the wet face.
Passed pass_pane(PaneRay ray, float spacing) {
    Passed p = Passed(vec3(0.0), 1.0, NO_CAP);
    vec3 d = ray.direction;
    if (d.z <= 0.0) return p;
    vec2 wet = wet_place(ray);
    float through = dry_pane(d.z), distance = 0.0;
    uint around = cap_around(wet);
    p.cap = around;
    if (around == NO_CAP) p.cap = cap_outside(wet, d, distance);
    vec3 dry = (1.0 - through) * pane.inside;
    p.light = dry;
    p.left = p.cap == NO_CAP ? through : 0.0;
    // A loop of no turn: CPU drivers run a branch that no lane takes.
    uint turns = p.cap == NO_CAP ? 0u : pane.indices;
    for (uint i = 0u; i < turns; ++i) {
        vec3 colors = turns == 1u ? vec3(1.0) : vec3(equal(uvec3(i), uvec3(0u, 1u, 2u)));
        PaneCap cap = cap_at(p.cap);
        float water = pane.water[i], spread = spacing * (water - 1.0) / cap.sphere;
        bool outside = around == NO_CAP;
        vec3 place = vec3(wet - cap.at, 0.0) + (outside ? distance : 0.0) * d;
        vec3 light = light_of_drop(cap, place, outside, d, water, spread);
        if (outside) light = through * light + dry;
        p.light = mix(p.light, light, colors);
    }
    return p;
}
#endif
