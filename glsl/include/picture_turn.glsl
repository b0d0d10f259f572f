#ifndef PICTURE_TURN_GLSL
#define PICTURE_TURN_GLSL
// How the picture of a far drop in a direction nearby is made that of a drop: by where it is looked up.
#include "frame.glsl"
#include "light_model.glsl"
#include "octahedron.glsl"

#define INDEX uintBitsToFloat(INDEX_GREEN)

// How far the lens that a drop is moves its picture for a turn of what it shows, in radii a radian: near the axis light leaves it by
// 2(1 - 1/n) a radius. What is moved by over MOST_BENT is not told by its slope.
const float MOST_BENT = 4.0;

// What is to be known of a drop for `on_picture`, by where it is in view space: in the basis of its picture's direction. That is
// off by 2° at most, and shows a drop as from infinitely far: a ray that passes the middle by b leaves at the angle of another view
// by the turn, and by b/d more, the drop's distance d in radii.
vec3 turn_of(vec4 sphere, uint texel) {
    vec3 n = texel_direction(texel), u, v;
    basis(n, u, v);
    float bent = clamp(0.5 * INDEX / (INDEX - 1.0), -MOST_BENT, MOST_BENT);
    float near = inversesqrt(dot(sphere.xyz, sphere.xyz));
    vec3 seen = near * (mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * sphere.xyz);
    return bent * vec3(clamp(vec2(dot(seen, u), dot(seen, v)), -0.05, 0.05), sphere.w * near);
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
