#version 460
#extension GL_GOOGLE_include_directive : require
// The pixels that drops of a pane touch, by rays from places of the lens through places of the pixel; one invocation a pixel.
// BLURRED: drops that are out of focus by what they look like (pane_looks.comp), rays for the others alone.
// See src/passes/pane/mod.rs.
#include "pane.glsl"
#include "pane_light.glsl"
#include "pane_pictures.glsl"
#include "places.glsl"
#ifdef BLURRED
#include "pane_blur.glsl"
#endif

layout(local_size_x = 64) in;

// The spiral of Vogel on the unit disc, turned by a part of a whole turn.
vec2 place_on_lens(uint number, uint count, float turned) {
    float angle = 2.39996323 * float(number) + 6.2831853 * turned, far = sqrt((float(number) + 0.5) / float(count));
    return far * vec2(cos(angle), sin(angle));
}

// What a pixel sees: the light of the pane and its drops, the share of the picture behind; the share of drops, and the nearest.
struct Seen {
    vec3 light;
    float left, drops;
    uint cap;
};

Seen by_rays(vec2 pixel) {
    bool has_lens = frame.lens.x > 0.0;
    // Through a lens neighbours take other places, or one would see the edges of the few pictures.
    vec2 turned = fract(vec2(dot(pixel, vec2(0.75487767, 0.56984029)), dot(pixel, vec2(0.81917251, 0.67104361))));
    float spacing = sqrt(abs(determinant(footprint_of(pixel + 0.5).step)) / float(pane.rays)), left = 0.0, beside = 1.0;
    vec3 light = vec3(0.0);
    uint rays = pane.rays, met = 0u, nearest = NO_CAP;
#ifdef BLURRED
    Blurred blurred = blurred_drops(pixel + 0.5);
    PaneRay middle = pane_ray(pixel + 0.5, vec2(0.0), 0.5);
    float through = middle.direction.z > 0.0 ? dry_pane(middle.direction.z) : 1.0;
    vec3 dry = (1.0 - through) * pane.inside;
    rays = blurred.has_sharp ? rays : 0u;
#endif
    for (uint i = 0u; i < rays; ++i) {
        vec2 in_pixel = has_lens ? fract(vec2(0.75487767, 0.56984029) * float(i) + turned) : place_of(i, rays);
        vec2 on_lens = has_lens ? place_on_lens(i, rays, turned.x) : vec2(0.0);
        float moment = fract(0.61803399 * (float(i) + 0.5));
        Passed p = pass_pane(pane_ray(pixel + in_pixel, on_lens, moment), spacing);
#ifdef BLURRED
        bool is_sharp = p.cap != NO_CAP && look_at(min(p.cap, pane.drops - 1u)).kind == BY_RAYS;
        light += is_sharp ? p.light : vec3(0.0);
        beside -= is_sharp ? 1.0 / float(rays) : 0.0;
#else
        bool is_sharp = p.cap != NO_CAP;
        light += p.light;
        left += p.left;
#endif
        met += uint(is_sharp);
        if (PANE_NEAREST != 0u && is_sharp) nearest = nearer_cap(nearest, p.cap);
    }
    float share = 1.0 / float(max(rays, 1u));
#ifdef BLURRED
    beside = max(beside - blurred.share, 0.0);
    if (PANE_NEAREST != 0u) nearest = nearer_cap(nearest, blurred.cap);
    float drops = min(share * float(met) + blurred.share, 1.0);
    return Seen(share * light + blurred.light + beside * dry, beside * through, drops, nearest);
#else
    return Seen(share * light, share * left, share * float(met), nearest);
#endif
}

void main() {
    uint invocation = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (invocation >= lists[1].count) return;
    uint number = touched[invocation], width = frame.window.z;
    vec2 pixel = vec2(frame.window.xy + uvec2(number % width, number / width));
    Seen seen = by_rays(pixel);
    radiance_out[number] = before_picture(number, seen.light, seen.left);
    if (PANE_NEAREST != 0u) nearest_caps[number] = uvec2(seen.cap, floatBitsToUint(seen.drops));
}
