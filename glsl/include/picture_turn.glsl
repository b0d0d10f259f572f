#ifndef PICTURE_TURN_GLSL
#define PICTURE_TURN_GLSL
// How the picture of a far drop in a direction nearby is made that of a drop: by where it is looked up.
#include "frame.glsl"
#include "light_model.glsl"
#include "octahedron.glsl"

#define INDEX uintBitsToFloat(INDEX_GREEN)

// A drop is a lens: near its axis it bends a ray that passes the middle at b radii by 2(1 - 1/n) b. So its picture seen from a direction
// that is off by an angle is moved by that angle over 2(1 - 1/n), in radii. Where that is over MOST_BENT angles, light is hardly bent, and
// not in proportion to b.
const float MOST_BENT = 4.0;

// What `on_picture` needs of a drop, whose centre and radius in view space are `sphere`: in x and y how far its picture moves as it is not
// in the picture's direction, in z how much as it is near (a ray at b radii is turned by b/d, with d its distance in radii). The direction
// is up to 3.8° off; `shown_from` holds those of some drops to the picture's edge, which the clamp leaves as they are.
vec3 turn_of(vec4 sphere, uint texel) {
    vec3 n = texel_direction(texel), u, v;
    basis(n, u, v);
    float bent = clamp(0.5 * INDEX / (INDEX - 1.0), -MOST_BENT, MOST_BENT);
    float near = inversesqrt(dot(sphere.xyz, sphere.xyz));
    vec3 seen = near * (mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * sphere.xyz);
    return bent * vec3(clamp(vec2(dot(seen, u), dot(seen, v)), -0.067, 0.067), sphere.w * near);
}

// By how much a place (s, t) of a drop's unit disc is shown aside on its picture. The angle by which light is bent grows with b nearly
// by 1/(1 - b²) of what it does at the axis; in a bubble up to where all light is reflected.
vec2 moved_on_picture(vec2 st, vec3 turn) {
    float most = min(INDEX, 1.0);
    return max(1.0 - dot(st, st) / (most * most), 0.0) * (turn.xy + turn.z * st);
}

vec2 on_picture(vec2 st, vec3 turn) {
    return st - moved_on_picture(st, turn);
}
#endif
