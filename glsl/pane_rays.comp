#version 460
#extension GL_GOOGLE_include_directive : require
// The pixels that drops of a pane touch, by rays from places of the lens through places of the pixel; one invocation a pixel.
// See src/passes/pane.rs.
#include "pane.glsl"
#include "pane_light.glsl"
#include "pane_pictures.glsl"
#include "places.glsl"

layout(local_size_x = 64) in;

// The spiral of Vogel on the unit disc, turned by a part of a whole turn.
vec2 place_on_lens(uint number, uint count, float turned) {
    float angle = 2.39996323 * float(number) + 6.2831853 * turned, far = sqrt((float(number) + 0.5) / float(count));
    return far * vec2(cos(angle), sin(angle));
}

// How far apart a pixel's rays are on the wet face.
float spacing_of(vec2 pixel) {
    vec2 middle = wet_place(pane_ray(pixel + 0.5, vec2(0.0), 0.5));
    vec2 right = wet_place(pane_ray(pixel + vec2(1.5, 0.5), vec2(0.0), 0.5)) - middle;
    vec2 down = wet_place(pane_ray(pixel + vec2(0.5, 1.5), vec2(0.0), 0.5)) - middle;
    float area = abs(right.x * down.y - right.y * down.x);
    return sqrt(area / float(PANE_RAYS));
}

void main() {
    uint invocation = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (invocation >= touched_count) return;
    uint number = touched[invocation], width = frame.window.z;
    vec2 pixel = vec2(frame.window.xy + uvec2(number % width, number / width));
    bool has_lens = frame.lens.x > 0.0;
    // Through a lens neighbours take other places, or one would see the edges of the few pictures.
    vec2 turned = fract(vec2(dot(pixel, vec2(0.75487767, 0.56984029)), dot(pixel, vec2(0.81917251, 0.67104361))));
    float spacing = spacing_of(pixel), left = 0.0;
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < PANE_RAYS; ++i) {
        vec2 in_pixel = has_lens ? fract(vec2(0.75487767, 0.56984029) * float(i) + turned) : place_of(i, PANE_RAYS);
        vec2 on_lens = has_lens ? place_on_lens(i, PANE_RAYS, turned.x) : vec2(0.0);
        float moment = fract(0.61803399 * (float(i) + 0.5));
        Passed p = pass_pane(pane_ray(pixel + in_pixel, on_lens, moment), spacing);
        light += p.light;
        left += p.left;
    }
    vec4 seen = halves_of(behind[number]);
    float share = 1.0 / float(PANE_RAYS);
    radiance_out[number] = halves(vec4(share * (left * seen.rgb + light), seen.a));
}
