#ifndef TILE_DROP_GLSL
#define TILE_DROP_GLSL
// Where a drop stands and what it covers on the screen.
#include "population.glsl"
#include "projection.glsl"
#include "splat.glsl"
#include "tile_buffers.glsl"

const float NEAR_RADII = 32.0; // a drop nearer than this does not look like a far one: rays at its rim are off by over 1.8°

// The silhouette: an ellipse of semi-axes r √(d²-r²) / (z²-r²), away from the image's middle, and
// r / √(z²-r²), in focal lengths; pixels.
struct Outline {
    vec2 center;
    vec2 box;     // half the sides of the box around it
    float radius; // of the disc of its area
};

Outline outline_of(Drop drop, float distance2) {
    vec3 v = drop.view;
    float radius2 = drop.radius * drop.radius, flat2 = v.z * v.z - radius2;
    float size = frame.image.z * drop.radius / flat2;
    Outline o;
    o.center = pixel_of(vec2(v.x, -v.y) * (-v.z / flat2 * frame.image.z));
    o.box = size * sqrt(v.xy * v.xy + flat2);
    o.radius = size * sqrt(sqrt((distance2 - radius2) * flat2));
    return o;
}

float opacity_at(float distance2) {
    float near = frame.camera_high.w, fade = frame.camera_low.w;
    return fade > 0.0 ? smoothstep(near, near + fade, sqrt(distance2)) : 1.0;
}

// Is it so small, far and opaque that two colours will do? `half_sides`: of its box as a splat.
bool is_small(Drop drop, Outline o, vec2 half_sides, float distance2) {
    return o.radius < SPLAT_PX && all(lessThan(half_sides, vec2(LONGEST_HALF_SIDE)))
        && distance2 >= NEAR_RADII * NEAR_RADII * drop.radius * drop.radius
        && opacity_at(distance2) == 1.0;
}

// The pixels whose squares a box meets, in the whole picture, so that a drop is drawn alike in every part of it:
// first and last; none if that is before.
ivec4 pixels_in(vec2 center, vec2 box) {
    ivec2 size = ivec2(frame.image.xy);
    return ivec4(clamp(ivec2(floor(center - box)), ivec2(0), size),
                 clamp(ivec2(ceil(center + box)) - 1, ivec2(-1), size - 1));
}
#endif
