#ifndef SHAPE_GLSL
#define SHAPE_GLSL
// The shape of a drop that is no sphere: a figure of revolution about the world's vertical, of two half spheroids of one
// width. Four numbers, over the radius of the sphere of equal volume: half its width; the heights of its upper and its
// lower half; the height over the drop's centre of the plane that joins them. Of a spheroid both halves are alike.
// The physics stands in src/optics/spheroid.rs, what of it is drawn in src/passes/shapes.rs.
#include "constants.glsl"
#include "projection.glsl"
#include "tile_buffers.glsl"

const vec4 ROUND = vec4(1.0, 1.0, 1.0, 0.0);

// Where the table of shapes has those of falling drops, by diameter, and those of drops placed by hand: `given` in
// src/passes/shapes.rs.
const uint BY_DIAMETER = 1, BY_HAND = BY_DIAMETER + DIAMETERS;

bool is_round(vec4 shape) {
    return SHAPE == SPHERES || shape == ROUND;
}

// By how much it is lower than wide; 0 of one that is higher.
float flatness_of_shape(vec4 shape) {
    return max(1.0 - 0.5 * (shape.y + shape.z) / shape.x, 0.0);
}

// The vertical in view space.
vec3 vertical() {
    return vec3(frame.right.y, frame.up.y, frame.back.y);
}

// Radius of a sphere about the centre that holds it.
float reach_of_shape(vec4 shape) {
    return max(shape.x, max(shape.y, shape.z)) + abs(shape.w);
}

// Where a line of unit direction `d` is that passes the centre at `to_ray`, of which the drop's outline along `d` is the
// unit circle. Along parallel rays each half's outline is half an ellipse: the surface is vertical at the joint, all
// around. `up`: the vertical. All in one frame, lengths in radii.
vec3 on_disc(vec4 shape, vec3 to_ray, vec3 d, vec3 up) {
    float sine = dot(d, up), cosine2 = max(1.0 - sine * sine, 1e-6);
    vec3 upright = up - sine * d, off = to_ray - shape.w * upright;
    float along = dot(off, upright), half_height = along > 0.0 ? shape.y : shape.z;
    float seen = sqrt(half_height * half_height * cosine2 + shape.x * shape.x * sine * sine);
    return off / shape.x + upright * (along / cosine2 * (1.0 / seen - 1.0 / shape.x));
}

// An ellipse on the screen: its centre, and the matrix (xx, xy, yy) whose inverse is its quadratic form; pixels.
struct Ellipse {
    vec2 center;
    vec3 spread;
};

// The outline of a spheroid about `c` in view space, of half width `across` and half height `high` along the vertical,
// scene units. Lines l touch it where lᵀ (c cᵀ - W) l = 0, W the inverse of its quadratic form; what cancels in that is
// left out here, so that a far drop's keeps its digits.
Ellipse ellipse_of(vec3 c, float across, float high) {
    vec3 u = vertical();
    float flat_part = across * across, more = (high - across) * (high + across);
    vec3 diagonal = flat_part + more * u * u;
    float xy = more * u.x * u.y, xz = more * u.x * u.z, yz = more * u.y * u.z;
    float focal = frame.image.z, below = 1.0 / (c.z * c.z - diagonal.z);
    float xx2 = c.z * c.z * diagonal.x - 2.0 * c.z * c.x * xz + c.x * c.x * diagonal.z + xz * xz - diagonal.z * diagonal.x;
    float yy2 = c.z * c.z * diagonal.y - 2.0 * c.z * c.y * yz + c.y * c.y * diagonal.z + yz * yz - diagonal.z * diagonal.y;
    float xy2 = c.z * c.z * xy - c.z * (c.x * yz + c.y * xz) + c.x * c.y * diagonal.z + xz * yz - diagonal.z * xy;
    Ellipse e;
    e.center = pixel_of(vec2(xz - c.x * c.z, c.y * c.z - yz) * (focal * below));
    e.spread = vec3(xx2, -xy2, yy2) * (focal * focal * below * below);
    return e;
}

float area_of(Ellipse e) {
    return 3.14159265 * sqrt(max(e.spread.x * e.spread.z - e.spread.y * e.spread.y, 0.0));
}

// A drop's outline: that of its upper half where a linear function of the pixel is negative, else that of its lower half.
// The cones of both halves touch them in the same two points of the joint, and the plane through these and the camera
// parts the two.
struct ShapeOutline {
    Ellipse upper, lower;
    vec2 gradient; // of that function, which is 0 on a line
    float at_upper; // its value at the upper ellipse's centre
};

ShapeOutline shape_outline_of(vec3 view, float radius, vec4 shape) {
    vec3 u = vertical(), c = view + shape.w * radius * u;
    ShapeOutline o;
    o.upper = o.lower = ellipse_of(c, shape.x * radius, shape.y * radius);
    o.gradient = vec2(0.0);
    o.at_upper = -1.0;
    if (shape.y != shape.z) {
        o.lower = ellipse_of(c, shape.x * radius, shape.z * radius);
        float along = dot(u, c), across = shape.x * radius;
        vec3 aside = c - along * u, n = along * aside + (across * across - dot(aside, aside)) * u;
        float length_n = max(length(n), 1e-30);
        o.gradient = vec2(n.x, -n.y) / length_n;
        o.at_upper = dot(n, ray_through(o.upper.center)) / length_n;
    }
    return o;
}

// How far one of the ellipses reaches in a direction along an axis of the screen, from the upper one's centre; -1e9
// where it is the other that does.
float reach_along(ShapeOutline o, bool upper, vec2 direction) {
    Ellipse e = o.lower;
    if (upper) e = o.upper;
    vec2 spread = vec2(dot(e.spread.xy, direction), dot(e.spread.yz, direction));
    vec2 to = e.center - o.upper.center + spread * inversesqrt(max(dot(spread, direction), 1e-30));
    bool own = (o.at_upper + dot(o.gradient, to) <= 0.0) == upper;
    return own ? dot(to, direction) : -1e9;
}

// The box around it: from its upper ellipse's centre to the left, top, right and bottom.
vec4 box_of(ShapeOutline o) {
    vec4 reach;
    for (uint i = 0u; i < 4u; ++i) {
        vec2 direction = vec2(i == 0u ? -1.0 : i == 2u ? 1.0 : 0.0, i == 1u ? -1.0 : i == 3u ? 1.0 : 0.0);
        float above = reach_along(o, true, direction), below = reach_along(o, false, direction);
        reach[i] = max(above, below);
        // Both are the other's by a rounding: the point is on the line.
        if (reach[i] < -1e8) reach[i] = sqrt(dot(o.upper.spread, vec3(direction.x * direction.x, 0.0, direction.y * direction.y)));
    }
    return vec4(-reach.xy, reach.zw);
}

// Half its depth along the view axis, counted from the drop's centre.
float depth_of_shape(float radius, vec4 shape) {
    float rise = vertical().z, high = max(shape.y, shape.z);
    return radius * (sqrt(shape.x * shape.x * (1.0 - rise * rise) + high * high * rise * rise) + abs(shape.w * rise));
}

// Is the camera in it? `from_drop`: the camera from the drop's centre along the world's axes, in radii.
bool holds_camera(vec4 shape, vec3 from_drop) {
    float over = from_drop.y - shape.w, high = over > 0.0 ? shape.y : shape.z;
    vec3 scaled = vec3(from_drop.xz / shape.x, over / high);
    return dot(scaled, scaled) <= 1.0;
}

// The inverse of the square root of a symmetric positive matrix (xx, xy, yy).
mat2 inverse_root(vec3 m) {
    float root = sqrt(max(m.x * m.z - m.y * m.y, 1e-30)), below = 1.0 / (root * sqrt(m.x + m.z + 2.0 * root));
    return mat2(m.z + root, -m.y, -m.y, m.x + root) * below;
}

// Takes an ellipse about its centre to the unit disc, turned as little as can be from what `near` makes of it.
mat2 to_disc_of(Ellipse e, mat2 near) {
    mat2 spread = near * mat2(e.spread.xy, e.spread.yz) * transpose(near);
    return inverse_root(vec3(spread[0].x, spread[0].y, spread[1].y)) * near;
}

// How a sphere's picture is flattened to a drop's, seen along a unit direction, in the plane of that picture's axes `u` and
// `w`: from places in the drop's to places in the sphere's.
mat2 flattening(vec4 shape, vec3 direction, vec3 u, vec3 w) {
    float cosine2 = max(1.0 - direction.y * direction.y, 1e-6), high = 0.5 * (shape.y + shape.z);
    float seen = sqrt(high * high * cosine2 + shape.x * shape.x * direction.y * direction.y);
    vec3 upright = vec3(0.0, 1.0, 0.0) - direction.y * direction;
    vec2 along = vec2(dot(upright, u), dot(upright, w)) * inversesqrt(cosine2);
    return mat2(1.0 / shape.x) + outerProduct(along, along) * (1.0 / seen - 1.0 / shape.x);
}

// Where on a drop's outline along `d` a place of the unit disc is: the opposite of `on_disc`, both halves taken for one
// of their mean height. `larger`: the outline's area over the disc's.
vec3 flattened(vec4 shape, vec3 at, vec3 d, vec3 up, out float larger) {
    float sine = dot(d, up), cosine2 = max(1.0 - sine * sine, 1e-6), high = 0.5 * (shape.y + shape.z);
    float seen = sqrt(high * high * cosine2 + shape.x * shape.x * sine * sine);
    vec3 upright = up - sine * d;
    larger = shape.x * seen;
    return shape.x * at + upright * (dot(at, up) / cosine2 * (seen - shape.x) + shape.w + 0.5 * (shape.y - shape.z));
}
#endif
