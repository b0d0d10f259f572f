#ifndef GLINT_SPOT_GLSL
#define GLINT_SPOT_GLSL
// The ellipse that a lens makes of the image of a bright source in a drop. Seen from all places of the lens an image is not where the drop
// is: its rays come from another depth, and in the plane of drop and source from another than across it.
#include "glints.glsl"
#include "spread_glints.glsl"

struct Spot {
    vec3 form;    // xx, xy and yy of S times its transpose, where S leads from the unit disc to pixels
    bool is_soft; // one of many that overlap: brightest in its middle
};

// From where the images in a drop are found: a place of the lens, and where the drop is seen from there.
struct Eye {
    vec3 axis;  // towards its centre
    float far;  // from that
    float sine; // of its angular radius
    float part; // of the whole lens that the ellipses are for, as the square of their size
    vec2 place; // on the lens, scene units
};

Eye eye_at(vec4 sphere, vec2 place, float part) {
    vec3 center = sphere.xyz - vec3(place, 0.0);
    float far = length(center);
    return Eye(center / far, far, min(sphere.w / far, 0.99999), part, place);
}

// From how many places of the lens the images of a drop are found: the more, the nearer it is. `blur`: the disc of its centre, pixels.
uint eyes_of(vec4 sphere, float blur, uint sources) {
    const float LEAST_WIDE_PX = 3.0, MOST_EYES = 256.0; // the latter of all sources together
    if (!is_wide_lens(sphere) || blur < LEAST_WIDE_PX || float(sources) * blur * blur > MOST_SPOTS) return 1u;
    float wanted = 3000.0 * frame.lens.x * frame.lens.x / dot(sphere.xyz, sphere.xyz);
    return uint(clamp(wanted, 8.0, MOST_EYES / float(sources)));
}

// One of them. Ellipses of twice their distance overlap evenly; places are so much farther in that the variance of all is the lens's.
Eye eye_of(vec4 sphere, uint number, uint eyes) {
    if (eyes == 1u) return eye_at(sphere, vec2(0.0), 1.0);
    float part = 4.0 / float(eyes);
    return eye_at(sphere, frame.lens.x * sqrt(1.0 - 2.0 / 3.0 * part) * place_on_unit_disc(number, eyes, 0.0), part);
}

// Radii in pixels of the smallest ellipse, and of the smallest soft one.
const float LEAST_PX = 0.2, LEAST_SOFT_PX = 1.0;
// So many radii of the drop an image moves at most, where the lens's middle is replaced by its edge: where it comes and goes, it would move
// without bound by its derivative.
const float MOST_MOVED = 0.25;

// One over the distances that the rays of an image seem to come from, in drops' distances: in the plane of axis and source, and across
// it. Those of the plane, of distances p from the drop's centre and directions β, meet dp/dβ beyond their point nearest to it. Those
// across meet on the line through the centre towards the source, around which all is symmetric.
vec2 nearness_of(Eye e, uint way, float b, float off) {
    bool outside = way == 0u, lens = way >= LENS_WAYS;
    float turns = outside ? 0.0 : lens ? 2.0 : float(2u * (way / 2u) + 2u);
    float c = sqrt((1.0 - b) * (1.0 + b)), inside = min(b / WATER, 0.99999), sin_a = e.sine * b;
    float slope = turns * c / WATER * inversesqrt(1.0 - inside * inside) - 2.0;
    float apart = slope * sqrt(1.0 - sin_a * sin_a) + e.sine * c, along = slope / (abs(apart) < 1e-6 ? 1e-6 : apart);
    float across = sin(off - asin(sin_a)) / max(sin(off), 1e-4);
    float most = MOST_MOVED * e.sine * e.far / frame.lens.x;
    return clamp(vec2(along, across), 1.0 - most, 1.0 + most);
}

// Where a small step across a ray leads on the screen, in focal lengths.
vec2 step_on_screen(vec3 ray, vec3 across) {
    float depth = max(-ray.z, 0.01);
    vec2 step = (across.xy + ray.xy * (across.z / depth)) / depth;
    return vec2(step.x, -step.y);
}

// `along`: across a ray, in the plane of axis and source.
Spot spot_of(Eye e, vec2 nearness, vec3 ray, vec3 along) {
    mat2 seen = mat2(step_on_screen(ray, along), step_on_screen(ray, cross(ray, along)));
    mat2 near = seen * mat2(nearness.x, 0.0, 0.0, nearness.y) * inverse(seen);
    mat2 s = sqrt(e.part) * frame.lens.z * (near / (e.far * max(-ray.z, 0.01)) - mat2(frame.lens.y));
    mat2 form = s * transpose(s);
    return Spot(vec3(form[0].x, form[0].y, form[1].y), e.part < 1.0);
}

// With the drop's way over the screen, of the variance of both, and no smaller than what pixels show.
Spot moved(Spot e, vec2 way) {
    float least = e.is_soft ? LEAST_SOFT_PX : LEAST_PX;
    e.form += vec3(way.x * way.x, way.x * way.y, way.y * way.y) / 3.0 + least * least * vec3(1.0, 0.0, 1.0);
    return e;
}

float determinant_of(vec3 form) {
    return form.x * form.z - form.y * form.y;
}

vec3 inverse_of(vec3 form) {
    return vec3(form.z, -form.y, form.x) / determinant_of(form);
}

// The sum of the parts of all pixels, within 1 %.
float area_of(Spot e) {
    float edge = e.is_soft ? 0.0 : (e.form.x + e.form.z) / 12.0 + 1.0 / 144.0;
    return 3.14159265 * sqrt(determinant_of(e.form) + edge);
}

// Part of a pixel around `off` that an ellipse takes whose inverse form is `inside`. The edge is a pixel wide.
float part_of_spot(vec3 inside, vec2 off, bool is_soft) {
    vec2 slope = vec2(inside.x * off.x + inside.y * off.y, inside.y * off.x + inside.z * off.y);
    float far2 = dot(slope, off), steep2 = dot(slope, slope);
    float to_edge = (1.0 - sqrt(far2)) * (steep2 > 0.0 ? sqrt(far2 / steep2) : 1.0);
    return is_soft ? max(2.0 - 2.0 * far2, 0.0) : clamp(to_edge + 0.5, 0.0, 1.0);
}
#endif
