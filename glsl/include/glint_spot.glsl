#ifndef GLINT_SPOT_GLSL
#define GLINT_SPOT_GLSL
// The ellipse that a lens makes of the image of a bright source in a drop. Seen from all places of the lens an image is not where the drop
// is: its rays come from another depth, and in the plane of drop and source from another than across it.
#include "glints.glsl"
#include "spread_glints.glsl"

struct Spot {
    vec3 form;    // xx, xy and yy of S times its transpose, where S leads from the unit disc to pixels
    bool is_soft; // one of many that overlap: brightest in its middle
    vec2 slope;   // of its light, a part of it a pixel
    vec2 way;     // over the screen while the shutter is open, pixels
};

// From where the images in a drop are found: a place of the lens, and where the drop is seen from there.
struct Eye {
    vec3 axis;  // towards its centre
    float far;  // from that
    float sine; // of its angular radius
    float part; // of the whole lens that the ellipses are for, as the square of their size
    vec2 place; // on the lens, scene units
    vec2 slant; // how an image's light grows over the lens, a part of it a radius
    vec2 way;   // of the image over the screen while the shutter is open, pixels
};

Eye eye_at(vec4 sphere, vec2 place, float part) {
    vec3 center = sphere.xyz - vec3(place, 0.0);
    float far = length(center);
    return Eye(center / far, far, min(sphere.w / far, 0.99999), part, place, vec2(0.0), vec2(0.0));
}

// How a drop moves over the screen while the shutter is open, pixels.
vec2 way_of(uint drop) {
    return is_spread() ? moves[2u * drop + 1u].xy : vec2(0.0);
}

// Do images move otherwise than their drop? In a near one each of its places shows the source elsewhere.
bool moves_otherwise(Eye e) {
    return e.sine >= far_sine() && dot(e.way, e.way) > 1.0;
}

// How an image of a part of a source moves then.
vec2 way_of_image(uint drop, vec4 sphere, uint way, vec3 source, float radius) {
    vec2 ends[2];
    for (uint i = 0u; i < 2u; ++i) {
        Eye e = eye_at(sphere + vec4((float(i) - 0.5) * moves[2u * drop].xyz, 0.0), vec2(0.0), 1.0);
        vec2 image = image_in(way, angle_between(e.axis, source), radius, e.sine);
        float sin_a = e.sine * image.x;
        vec3 ray = sqrt(1.0 - sin_a * sin_a) * e.axis + sin_a * aside_of(e.axis, source);
        if (image.y <= 0.0 || ray.z > -0.01) return way_of(drop);
        ends[i] = frame.image.z * vec2(ray.x, -ray.y) / -ray.z;
    }
    return ends[1] - ends[0];
}

// One of several eyes. Ellipses of 2.5 times their distance overlap evenly; places are so much farther in that the variance of all is the
// lens's.
Eye eye_of(vec4 sphere, uint number, uint eyes) {
    if (eyes == 1u) return eye_at(sphere, vec2(0.0), 1.0);
    float part = 6.25 / float(eyes);
    return eye_at(sphere, frame.lens.x * sqrt(1.0 - 2.0 / 3.0 * part) * place_on_unit_disc(number, eyes, 0.0), part);
}

// Where it comes and goes an image moves without bound, by its derivative. Between middle and edge of the lens it moves by so many radii of
// the drop at most.
const float MOST_MOVED = 0.25;

// One over the distances that the rays of an image seem to come from, in drops' distances: in the plane of axis and source, and across
// it. Those of the plane, of distances p from the drop's centre and directions β, meet dp/dβ beyond their point nearest to it. Those
// across meet on the line through the centre towards the source, around which all is symmetric.
vec2 nearness_of(Eye e, uint way, float b, float off) {
    float a = asin(e.sine * b), slope = angle_at(asin(b), turns_of(way), 0.0, 0.0).y;
    float apart = slope * cos(a) + e.sine * sqrt((1.0 - b) * (1.0 + b));
    return vec2(slope / (abs(apart) < 1e-6 ? 1e-6 : apart), sin(off - a) / max(sin(off), 1e-4));
}

// Eyes for one source at most; fewer where turns are few (glint_turns.glsl).
const uint MOST_EYES = 128;

// How the images of a source by each of the ways are seen from the lens's middle and from places of its edge.
struct Looks {
    uint uneven;       // ways by which some see one and others none, or elsewhere, a bit each
    uint slants[WAYS]; // of the others (Eye), halves
    float least;       // radius in pixels of the smallest spot's shorter axis
};

// `source`: in view space.
Looks looks_at(vec4 sphere, vec4 source, float blur) {
    const uint AT_EDGE = 8u;
    const float ALIKE = 0.1, MOST_SLANT = 1.0, LEAST_SPOT_PX = 3.0;
    Looks looks;
    looks.uneven = 0u;
    looks.least = blur;
    take_index(INDICES / 2u);
    for (uint way = 0u; way < WAYS; ++way) {
        vec3 middle = vec3(0.0);
        vec2 slant = vec2(0.0);
        float spot = 0.0;
        bool is_even = true;
        for (uint i = 0u; i <= AT_EDGE; ++i) {
            float angle = 6.2831853 / float(AT_EDGE) * float(i);
            vec2 place = i == 0u ? vec2(0.0) : vec2(cos(angle), sin(angle));
            Eye e = eye_at(sphere, frame.lens.x * place, 1.0);
            float off = angle_between(e.axis, source.xyz);
            vec2 image = image_in(way, off, max(source.w, 1e-3), e.sine);
            vec3 seen = vec3(nearness_of(e, way, image.x, off), image.y);
            if (i == 0u) middle = seen;
            slant += 2.0 / float(AT_EDGE) * seen.z * place;
            is_even = is_even && seen.z > 0.0 && all(lessThanEqual(abs(seen.xy - middle.xy), ALIKE * max(abs(middle.xy), 1.0)));
            vec2 axes = frame.lens.z * abs(seen.xy / e.far - frame.lens.y);
            if (seen.z > 0.0) spot = max(spot, max(axes.x, axes.y));
            if (seen.z > 0.0) looks.least = min(looks.least, min(axes.x, axes.y));
        }
        is_even = is_even && dot(slant, slant) <= MOST_SLANT * MOST_SLANT * middle.z * middle.z;
        looks.uneven |= spot > LEAST_SPOT_PX && !is_even ? 1u << way : 0u;
        looks.slants[way] = is_even ? packHalf2x16(slant / middle.z) : 0u;
    }
    return looks;
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
    float most = MOST_MOVED * e.sine * e.far / frame.lens.x;
    nearness = clamp(nearness, 1.0 - most, 1.0 + most);
    mat2 near = seen * mat2(nearness.x, 0.0, 0.0, nearness.y) * inverse(seen);
    mat2 s = sqrt(e.part) * frame.lens.z * (near / (e.far * max(-ray.z, 0.01)) - mat2(frame.lens.y));
    mat2 form = s * transpose(s);
    // A place higher on the lens sees it higher up; the screen's rows go down.
    vec2 slope = abs(determinant(s)) > 1e-6 ? inverse(transpose(s)) * vec2(-e.slant.x, e.slant.y) : vec2(0.0);
    return Spot(vec3(form[0].x, form[0].y, form[1].y), e.part < 1.0, slope, e.way);
}

// A soft spot of what moves meanwhile, of the variance of both.
Spot moved(Spot e) {
    e.form += 0.5 * vec3(e.way.x * e.way.x, e.way.x * e.way.y, e.way.y * e.way.y);
    e.way = vec2(0.0);
    return e;
}

// A smaller spot is drawn by points: of its edge pixels show nothing, and a point gives all of its light to one of them.
const float POINTED_PX = 1.0;
const uint POINTS = 16;
// The square of the least way of a spot, in pixels, that is told.
const float LEAST_WAY2 = 1.0;

bool is_pointed(Spot e) {
    return dot(e.way, e.way) < LEAST_WAY2 && e.form.x + e.form.z < 2.0 * POINTED_PX * POINTED_PX;
}

// Where one of them is, from the spot's middle.
vec2 point_of(Spot e, uint number) {
    // The points of a soft spot are so much farther in that their variance is its own.
    vec2 place = (e.is_soft ? sqrt(2.0 / 3.0) : 1.0) * place_on_unit_disc(number, POINTS, 0.0);
    float wide = sqrt(e.form.x), slant = e.form.y / max(wide, 1e-9);
    return vec2(wide * place.x, slant * place.x + sqrt(max(e.form.z - slant * slant, 0.0)) * place.y);
}

// No axis is narrower than what pixels show of it, so that they have all of the spot's light together. Of many thin ones that lie side by
// side askew each would show.
Spot broadened(Spot e) {
    float least2 = e.is_soft ? 1.0 + 0.1 * (e.form.x + e.form.z) : 0.25;
    e.form += least2 * vec3(1.0, 0.0, 1.0);
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

// Part of the light of a pixel around `off` from the middle of a spot whose form's inverse is `inside`, 1 in the middle of one at rest. The
// edge is a pixel wide; one that moves is there for a part of the time.
float part_of_spot(Spot e, vec3 inside, vec2 off) {
    vec2 slope = vec2(inside.x * off.x + inside.y * off.y, inside.y * off.x + inside.z * off.y);
    float far2 = dot(slope, off), steep2 = dot(slope, slope), part;
    if (e.is_soft) {
        part = max(2.0 - 2.0 * far2, 0.0);
    } else if (dot(e.way, e.way) < LEAST_WAY2) {
        part = clamp((1.0 - sqrt(far2)) * (steep2 > 0.0 ? sqrt(far2 / steep2) : 1.0) + 0.5, 0.0, 1.0);
    } else {
        float way2 = inside.x * e.way.x * e.way.x + 2.0 * inside.y * e.way.x * e.way.y + inside.z * e.way.y * e.way.y;
        float middle = dot(slope, e.way) / way2, meets2 = middle * middle - (far2 - 1.0) / way2, half_time = sqrt(max(meets2, 0.0));
        float from = max(middle - half_time, -0.5), to = min(middle + half_time, 0.5);
        part = max(to - from, 0.0);
        off -= 0.5 * (from + to) * e.way;
    }
    // One side gains what the other loses.
    return part * clamp(1.0 + dot(e.slope, off), 0.0, 2.0);
}
#endif
