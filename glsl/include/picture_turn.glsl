#ifndef PICTURE_TURN_GLSL
#define PICTURE_TURN_GLSL
// How the picture of a far drop in a direction nearby is made that of a drop: by where it is looked up.
#include "frame.glsl"
#include "light_model.glsl"
#include "octahedron.glsl"

#define INDEX uintBitsToFloat(INDEX_GREEN)

// What `on_picture` needs of a drop, whose centre and radius in view space are `sphere`: in x and y the angle by which it is not in
// the picture's direction, in z the angle by which it turns rays as it is near (one at b radii by b/d, with d its distance in radii).
// The direction is up to 3.8° off; `shown_from` holds those of some drops to the picture's edge, which the clamp leaves as they are.
vec3 turn_of(vec4 sphere, uint texel) {
    vec3 n = texel_direction(texel), u, v;
    basis(n, u, v);
    float near = inversesqrt(dot(sphere.xyz, sphere.xyz));
    vec3 seen = near * (mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * sphere.xyz);
    return vec3(clamp(vec2(dot(seen, u), dot(seen, v)), -0.067, 0.067), sphere.w * near);
}

// Pictures of drops whose index is so near to 1 are turned by the angles themselves: they bend light little, and most of it close to the rim.
const float NEARLY_ONE = 0.15;

// Where light that a drop shows at a place of its unit disc is on the picture. A drop bends a ray at b radii by twice φ = θ - θ', its
// angles outside and inside, with sin θ = b and sin θ' = b/n; the same light passes another place of the picture by an angle 2φ less the
// turn. That place follows from its φ by tan θ = sin φ / (cos φ - 1/n), and is beyond the rim where cos φ < 1/n.
vec2 on_picture_by_angles(vec2 st, vec2 turned) {
    float into = 1.0 / INDEX, b2 = dot(st, st), inside = 1.0 - b2 * into * into;
    if (inside <= 0.0) return st;
    vec2 sine = (sqrt(inside) - into * sqrt(max(1.0 - b2, 0.0))) * st - 0.5 * turned;
    float sine2 = dot(sine, sine), beside = sqrt(max(1.0 - sine2, 0.0)) - into;
    if (INDEX > 1.0) beside = max(beside, 0.0);
    return sign(INDEX - 1.0) * sine * inversesqrt(max(beside * beside + sine2, 1e-12));
}

// Finds that place; of indices farther from 1 without roots: light is bent by 2(1 - 1/n) b near the axis, and this grows with b nearly by
// 1/(1 - b²), in a bubble up to where all light is reflected.
vec2 on_picture(vec2 st, vec3 turn) {
    vec2 turned = turn.xy + turn.z * st;
    if (abs(INDEX - 1.0) < NEARLY_ONE) return on_picture_by_angles(st, turned);
    float most = min(INDEX, 1.0);
    return st - 0.5 * INDEX / (INDEX - 1.0) * max(1.0 - dot(st, st) / (most * most), 0.0) * turned;
}

// Finds where a drop shows what is at a place of its picture.
vec2 from_picture(vec2 st, vec3 turn) {
    return on_picture(st, -turn);
}
#endif
