#ifndef GLINT_PARTS_GLSL
#define GLINT_PARTS_GLSL
// A source's disc in parts, each of which has an image of its own in a drop.
#include "glints.glsl"

struct Parts {
    vec3 toward, u, v; // its middle and two directions across, in view space
    float wide;        // angular radius of the source
    uint count;
    float part;        // root of a part's share of the solid angle
    float radius;      // angular, of a part
};

Parts parts_in(vec3 toward, float wide, vec3 axis, uint count) {
    Parts p;
    p.toward = toward;
    p.u = aside_of(p.toward, axis);
    p.v = cross(p.toward, p.u);
    p.wide = wide;
    p.count = count;
    p.part = inversesqrt(float(p.count));
    p.radius = max(wide * p.part, 1e-3);
    return p;
}

// Where a part is: evenly over the disc, by turns of the golden angle.
vec3 toward_part(Parts p, uint number) {
    float out_by = p.count > 1u ? p.wide * p.part * sqrt(float(number) + 0.5) : 0.0, turn = 2.39996323 * float(number);
    return normalize(p.toward + out_by * (cos(turn) * p.u + sin(turn) * p.v));
}
#endif
