#ifndef MOTION_GLSL
#define MOTION_GLSL
// How drops move on the screen while the shutter is open. A drop's place is that at the middle of the exposure.
#include "lens.glsl"
#include "tile_drop.glsl"

// A drop with a longer way is blurred, or a streak: pixels, and radii.
const float SHORT_PX = 1.0, SHORT_RADII = 1.5;
// A larger drop that moves by so many radii is as faint as a quarter, so that one colour will do as far as it is narrow. In a
// streak as wide as several pixels the drop's colours are seen side by side: up to so many times as long.
const float FAINT_RADII = 8.0, NARROW_PX = 0.6, WIDE = 5.0;
// One that is out of focus is, if it is as faint as that, by as much less up to so many pixels.
const float FAINT = 0.25, FAINT_DISC_PX = 2.5;
// Nearer than this, in radii, even a faint drop is no far one; the nearer, the fainter, down to the other.
const float FAINT_NEAR_RADII = 4.0, FAINTEST_NEAR_RADII = 1.5;
// Most that a drop's depth may change by for its outline to be taken for one that moves evenly.
const float EVEN = 1.25;
// Most that the outline of a drop that is not faint may be off by then, at the ends of its way: as a part of the way, and in
// pixels; the larger of the two counts. (A black drop 3 radii from the camera that fell by half of its breadth was up to 37 levels of
// 255 too dark or too bright.)
const float MOST_OFF = 0.02, MOST_OFF_PX = 0.1;

struct Path {
    vec3 moved;    // in view space
    vec2 way;      // of the outline, pixels
    vec2 aside;    // of the way's middle from the outline there, pixels
    float larger;  // the outline's mean area over that in the middle
    bool even;     // it is seen as an outline that moves evenly
    bool near;     // it comes to the camera's plane
};

// How far a drop moves, along the world's axes.
vec3 motion_of(uint index) {
    if (is_by_hand(index)) return placed_motions[by_hand_number(index)].xyz;
    return random_motion(index);
}

Path path_at_rest() {
    return Path(vec3(0.0), vec2(0.0), vec2(0.0), 1.0, true, false);
}

Path path_of(vec3 v, float radius, vec3 motion) {
    Path p;
    p.moved = view_space(motion);
    vec3 a = v - 0.5 * p.moved, b = v + 0.5 * p.moved;
    float nearest = min(-a.z, -b.z), farthest = max(-a.z, -b.z);
    p.near = nearest < 1.01 * radius;
    p.even = !p.near && farthest <= EVEN * nearest;
    vec2 from = vec2(a.x, -a.y) / -a.z, to = vec2(b.x, -b.y) / -b.z, middle = vec2(v.x, -v.y) / -v.z;
    p.way = p.near ? vec2(0.0) : frame.image.z * (to - from);
    p.aside = p.near ? vec2(0.0) : frame.image.z * (0.5 * (from + to) - middle);
    // The outline's ellipse lies farther from the picture's middle than the drop's centre does, and is longer the farther it lies.
    float square = max(v.z * v.z - radius * radius, 1e-30), pixels = frame.image.z * radius * inversesqrt(square), along = length(p.way);
    float longer = abs(length(b) - length(a)) / -v.z;
    float off = 0.5 * along * radius * radius / square + pixels * longer;
    p.even = p.even && (along > FAINT_RADII * pixels || off <= max(MOST_OFF * along, MOST_OFF_PX));
    p.larger = p.even ? v.z * v.z / (a.z * b.z) : 1.0;
    return p;
}

// How far beyond each edge of the view a place is.
vec4 beyond(vec3 v) {
    precise float depth = -v.z;
    precise float left = -v.x * frame.frustum_x.x - depth * frame.frustum_x.y;
    precise float right = v.x * frame.frustum_x.z - depth * frame.frustum_x.w;
    precise float top = v.y * frame.frustum_y.x - depth * frame.frustum_y.y;
    precise float bottom = -v.y * frame.frustum_y.z - depth * frame.frustum_y.w;
    return vec4(left, right, top, bottom);
}

// `visibility` of a drop that moves: whether it may be in view at any time; the same as `Sight::visibility_moving`, bit for
// bit.
uint visibility_moving(vec3 v, vec3 moved, float radius) {
    precise vec3 half_way = 0.5 * moved;
    precise vec3 from = v - half_way, to = v + half_way;
    precise float square = (v.x * v.x + v.y * v.y) + v.z * v.z;
    precise float near2 = frame.camera_high.w * frame.camera_high.w;
    float reach = max(reach_across(from, radius), reach_across(to, radius));
    bool in_frustum = all(lessThanEqual(min(beyond(from), beyond(to)), vec4(reach)));
    if (!in_frustum || square < near2 || max(-from.z, -to.z) <= -radius) return OUT_OF_VIEW;
    return min(-from.z, -to.z) <= radius ? BESIDE_CAMERA : VISIBLE;
}

// How far the outline reaches over its place in the middle.
vec2 reach_of(Path p) {
    return 0.5 * abs(p.way);
}

// Is the way so short that it only blurs a small drop?
bool is_short(Outline o, Path p) {
    return p.even && length(p.way) <= max(SHORT_PX, SHORT_RADII * o.radius);
}

// Is a drop that is no splat part of the streak layer? It is far, and small or faint.
bool is_streak(Drop drop, Outline o, Path p, float distance2) {
    float length = length(p.way), faint = FAINT_RADII * o.radius * clamp(o.radius / NARROW_PX, 1.0, WIDE);
    float near = max(FAINT_NEAR_RADII * FAINT_RADII * o.radius / max(length, 1e-30), FAINTEST_NEAR_RADII) * drop.radius;
    return SPLAT_PX > 0.0 && p.even && !is_short(o, p)
        && (length > faint
                ? distance2 >= near * near
                : o.radius < SPLAT_PX && distance2 >= NEAR_RADII * NEAR_RADII * drop.radius * drop.radius);
}

// Is a drop that is out of focus part of the streak layer? It is far, and small or faint.
bool is_one_colour_disc(Drop drop, Outline o, Path p, float blur, float distance2) {
    if (SPLAT_PX == 0.0 || !p.even) return false;
    float wide = max(o.radius, blur), area = wide * (wide + 0.64 * length(p.way));
    float near2 = distance2 / (drop.radius * drop.radius);
    bool little = is_short(o, p) && is_little(o.radius, blur);
    return !little && (o.radius * o.radius * clamp(o.radius, 1.0, FAINT_DISC_PX) <= FAINT * area
                           ? near2 >= FAINT_NEAR_RADII * FAINT_NEAR_RADII
                           : o.radius < SPLAT_PX && near2 >= NEAR_RADII * NEAR_RADII);
}

// The box of a splat that moves a little: of the variance of the two together; and how opaque it is for that.
vec2 blurred(vec2 half_sides, Path p, out float opacity) {
    vec2 wide = sqrt(half_sides * half_sides + 0.25 * p.way * p.way);
    opacity = half_sides.x * half_sides.y / (wide.x * wide.y);
    return wide;
}
#endif
