#ifndef LENS_GLSL
#define LENS_GLSL
// What a lens makes of drops: of a point that is out of focus a disc.
//
// Seen from a place L of the lens, what is at depth z stands f L (1/z - 1/focus) beside where the pinhole in the lens's
// middle sees it (f: focal length in pixels). So a drop's outline is spread evenly over a disc.
#include "tile_buffers.glsl"

// Radius in pixels under which nothing is changed by such a disc; and the largest that is told.
const float LEAST_BLUR_PX = 0.5, MOST_BLUR_PX = 1e6;

// Whether drops are seen through a lens in this frame.
bool is_lens() {
    return HAS_LENS != 0u && frame.lens.x != 0.0;
}

// Radius in pixels of the disc that a point at a depth becomes.
float disc_of(float depth) {
    return frame.lens.z * abs(1.0 / depth - frame.lens.y);
}

// The largest of a drop that moves so far in view space: that of its nearest or its farthest point. 0 where it changes
// nothing.
float blur_of(vec3 v, vec3 moved, float radius) {
    if (!is_lens()) return 0.0;
    float deep = 0.5 * abs(moved.z) + radius, nearest = -v.z - deep;
    float blur = nearest > 0.0 ? min(max(disc_of(nearest), disc_of(-v.z + deep)), MOST_BLUR_PX) : MOST_BLUR_PX;
    return blur >= LEAST_BLUR_PX ? blur : 0.0;
}

// How far from its centre a drop is seen across the view axis: by its radius, and by how far the places of the lens see it
// apart; the same as `Sight::reach`, bit for bit.
float reach_across(vec3 v, float radius) {
    if (!is_lens()) return radius;
    precise float reach = radius + frame.lens.x * (abs(1.0 + v.z * frame.lens.y) + radius * frame.lens.y);
    return reach;
}

// How far a drop somewhere in a box is seen at most.
float reach_from_box(vec3 center, vec3 half_size, float radius) {
    if (!is_lens()) return radius;
    float depth = -dot(frame.back.xyz, center), deep = dot(abs(frame.back.xyz), half_size) + radius;
    float apart = max(abs(1.0 - (depth - deep) * frame.lens.y), abs(1.0 - (depth + deep) * frame.lens.y));
    return radius + 1.001 * frame.lens.x * apart;
}

// Where a sphere is seen along one axis of the screen, in focal lengths from the middle: by the places of the lens at both
// its ends, for of those between them none sees it farther out. It is wholly before the camera's plane.
vec2 seen_through_lens(float across, float depth, float radius) {
    float flat2 = depth * depth - radius * radius;
    vec2 at = across - vec2(frame.lens.x, -frame.lens.x);
    vec2 middle = at * depth / flat2 + vec2(frame.lens.x, -frame.lens.x) * frame.lens.y;
    vec2 extent = radius * sqrt(at * at + flat2) / flat2;
    return vec2(min(middle.x - extent.x, middle.y - extent.y), max(middle.x + extent.x, middle.y + extent.y));
}

// The sides of a small drop's box that is out of focus: of the variance of box and disc together; and how opaque it is for
// that.
vec2 defocused(vec2 half_sides, float blur, inout float opacity) {
    vec2 wide = sqrt(half_sides * half_sides + 0.75 * blur * blur);
    opacity *= half_sides.x * half_sides.y / (wide.x * wide.y);
    return wide;
}

// Is a small drop only blurred a little?
bool is_little(float radius, float blur) {
    return blur <= max(1.0, 1.5 * radius);
}

// The place of the unit disc that stands for one of the unit square.
vec2 on_unit_disc(vec2 square) {
    return sqrt(square.x) * vec2(cos(6.2831853 * square.y), sin(6.2831853 * square.y));
}

// A place on the unit disc, the spiral of Vogel, turned by a part of a whole turn.
vec2 place_on_unit_disc(uint number, uint count, float turned) {
    float angle = 2.39996323 * float(number) + 6.2831853 * turned, far = sqrt((float(number) + 0.5) / float(count));
    return far * vec2(cos(angle), sin(angle));
}
#endif
