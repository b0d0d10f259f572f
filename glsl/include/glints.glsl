#ifndef GLINTS_GLSL
#define GLINTS_GLSL
// The images of small bright sources in a drop, found instead of met by rays: the float32 version of
// src/reference/glints.rs, which derives it.
//
// All happens in the plane of the drop's axis (from the camera to its centre) and the source. A ray that leaves
// the axis by α meets the drop at the angle of incidence θ, sin α = (r/d) sin θ, and comes from ψ off the axis:
//   reflected outside               ψ = α - 2θ + π
//   after k internal reflections    ψ = α - 2θ + 2(k+1)θt - kπ
// ψ is concave in θ, so it has one crest (the rainbow's ray, or θ = 0) and is monotone on either side of it. A
// source Φ off the axis is seen where ψ = Φ, or on the other side of the drop where ψ = -Φ, up to whole turns.
#include "light_model.glsl"
#include "optics.glsl"
#include "sources.glsl"

const float HALF_TURN = 3.14159265358979;

// The ways of light that have images: 0 by the reflection outside; after k = 0, 1, 2, 3 internal reflections between
// crest and rim 1, 3, 5, 9, between the middle and the crest 2, 4, 8 (k = 1, 2, 3). A near drop, of water nearer than 2 radii, is a lens
// that also shows upright what is behind it: 6 between middle and crest, 7 between crest and rim. That holds for indices from
// 1.18 to 1.41; beyond, the ways of k = 2 or 1 reach over another half turn. Of k = 3 less than a half turn has light enough.
const uint WAYS = 10, LENS_WAYS = 6, THIRD_WAYS = 8; // the first of either
const uint MOST_ORDERS = 2; // internal reflections of small drops; after more of them 0.1 % of the light

// ψ and its slope. `turns`: 2(k+1), 0 outside; `start`: ψ of the ray through the middle.
vec2 angle_at(float incidence, float turns, float start, float sine) {
    float b = sin(incidence), c = cos(incidence), inside = b / WATER, seen = sine * b;
    return vec2(asin(seen) - 2.0 * incidence + turns * asin(inside) + start,
                sine * c * inversesqrt(1.0 - seen * seen) - 2.0
                    + turns * c / WATER * inversesqrt(1.0 - inside * inside));
}

// The angle of incidence at the crest. A fixed point that each pass brings four times nearer, from that of a far drop.
float crest_of(float turns, float sine) {
    if (sine + turns / WATER <= 2.0) return 0.0;
    float n2 = WATER * WATER, c = turns > 2.0 ? sqrt((n2 - 1.0) / (0.25 * turns * turns - 1.0)) : 1.0;
    for (uint i = 0u; i < 6u; ++i) {
        c = min(1.0, 2.0 / (sine * inversesqrt(1.0 - sine * sine * (1.0 - c * c))
                            + turns * inversesqrt(n2 - 1.0 + c * c)));
    }
    return acos(c);
}

// The rays of a way: from its crest over `reach` towards the rim (away = 1) or the middle (-1).
struct Branch {
    float turns, start, sine;
    float crest, reach, away;
    float top, bottom; // ψ at the crest and at the other end
    float steepness;   // of ψ at the crest: 0 but for a crest in the middle
};

// How far from the crest ψ has a value between top and bottom: steps of Newton's from the parabola through both ends.
float newton(Branch w, float from_crest, float value) {
    vec2 at = angle_at(w.crest + w.away * from_crest, w.turns, w.start, w.sine);
    return clamp(from_crest - (at.x - value) / min(w.away * at.y, -1e-3), 0.0, w.reach);
}

float incidence_of(Branch w, float value) {
    float drop = w.top - value;
    float bend = max(2.0 * (w.top - w.bottom - w.steepness * w.reach) / (w.reach * w.reach), 0.0);
    float u = 2.0 * drop / (w.steepness + sqrt(max(w.steepness * w.steepness + 2.0 * bend * drop, 1e-12)));
    // For water b is then within 6e-5 farther than 30 radii; by a third step within 1e-6 farther than 5, within 4e-4 for any drop.
    // Lower indices take two more.
    u = newton(w, clamp(u, 0.0, w.reach), value);
    u = newton(w, u, value);
    for (uint i = 0u; w.sine > 1.0 / 30.0 && i < 1u; ++i) u = newton(w, u, value);
    if (lowest_index() < 1.3) u = newton(w, newton(w, u, value), value);
    return w.crest + w.away * u;
}

// The ways of k = 2 and of k = 3, a bit each. But for the rainbow an image of k = 2 has a thirtieth of the light of that outside.
const uint FAINT_WAYS = 48u, FAINTEST_WAYS = 768u;

// ψ at the rim of a far drop after k internal reflections, and its greatest.
float rim_angle(float k, float index) {
    return (k + 1.0) * (2.0 * asin(1.0 / index) - HALF_TURN);
}

float crest_angle(float k, float index) {
    float c = sqrt((index * index - 1.0) / (k * (k + 2.0))), s = sqrt(1.0 - c * c);
    return 2.0 * (k + 1.0) * asin(s / index) - 2.0 * acos(c) - k * HALF_TURN;
}

// How much greater ψ is in a near drop, at most.
float nearness_adds(float sine) {
    return 1.6 * sine + 0.015;
}

// The ways that may have images, a bit each, so that most of them need no look. Of k = 2 the rainbow alone.
uint ways_of(float off, float radius, float sine) {
    float low = off - radius, high = off + radius, adds = nearness_adds(sine), least = lowest_index(), most = highest_index();
    float second_bow = 2.0 * HALF_TURN + crest_angle(2.0, least), second_end = 2.0 * HALF_TURN + crest_angle(2.0, most) - 0.36;
    uint ways = low < -rim_angle(0.0, most) ? 3u : 1u;
    if (high > -crest_angle(1.0, least) - adds) ways |= low < -rim_angle(1.0, most) + adds ? 12u : 4u;
    if (high > second_end && low < second_bow + adds) ways |= FAINT_WAYS;
    if (sine > 1.99 - 2.0 / least && low < adds) ways |= 3u << LENS_WAYS;
    return ways;
}

// The ways that only a large drop shows; `low`: least angle from the axis.
uint faint_ways(float low, float sine) {
    return FAINT_WAYS | (low < 2.0 * HALF_TURN + crest_angle(3.0, lowest_index()) + nearness_adds(sine) ? FAINTEST_WAYS : 0u);
}

// Internal reflections on a way, and its `turns`.
uint order_of(uint way) {
    return way < LENS_WAYS ? way / 2u : way < THIRD_WAYS ? 0u : 3u;
}

float turns_of(uint way) {
    return way == 0u ? 0.0 : float(2u * order_of(way) + 2u);
}

// The image by a way of a disc `off` the axis with an angular `radius`. x: its impact parameter, negative on the side
// away from the source; y: its light over the source's light and the drop's squared radius, 0 if there is none.
// The mean over the disc's breadth, so that a rainbow's image, which has no bound, has one.
vec2 image_of(uint way, float off, float radius, float sine) {
    bool outside = way == 0u, lens = way / 2u == LENS_WAYS / 2u;
    uint order = order_of(way);
    if (outside ? REFLECTION == 0u : order > INTERNAL_REFLECTIONS) return vec2(0.0);
    Branch w;
    w.turns = turns_of(way);
    w.start = outside ? HALF_TURN : -HALF_TURN * float(order);
    w.sine = sine;
    w.crest = crest_of(w.turns, sine);
    w.away = (way & 1u) == 0u && !outside ? -1.0 : 1.0;
    w.reach = w.away < 0.0 ? w.crest : 0.5 * HALF_TURN - w.crest;
    vec2 top = angle_at(w.crest, w.turns, w.start, sine);
    w.top = top.x;
    w.steepness = max(-w.away * top.y, 0.0);
    w.bottom = angle_at(w.crest + w.away * w.reach, w.turns, w.start, sine).x;

    bool same_side = outside || order > 1u || lens;
    vec2 range = vec2(max(off - radius, 0.0), min(off + radius, HALF_TURN));
    vec2 values = same_side ? range - (order > 1u ? 2.0 * HALF_TURN : 0.0) : -range.yx;
    float low = max(values.x, w.bottom), high = min(values.y, w.top);
    if (low >= high || w.reach < 1e-3) return vec2(0.0);

    float first = incidence_of(w, low), last = incidence_of(w, high);
    // Differences of squared sines and of cosines as products, which keep their digits.
    float squares = abs(sin(first + last) * sin(first - last));
    float annulus = 2.0 * sin(0.5 * (range.x + range.y)) * sin(0.5 * (range.y - range.x));
    float b = min(sqrt(0.5 * (sin(first) * sin(first) + sin(last) * sin(last))), 0.99999);

    float f = reflectance(Intersection(vec3(0.0), vec3(0.0), b, sqrt((1.0 - b) * (1.0 + b))));
    float share = f;
    if (!outside) {
        share = (1.0 - f) * (1.0 - f) * (order > 0u ? f : 1.0) * (order > 1u ? f : 1.0) * (order > 2u ? f : 1.0);
        // What the orders after the second carry is left out.
        bool takes_rest = CONSERVING != 0u && order == INTERNAL_REFLECTIONS && order < MOST_ORDERS;
        if (takes_rest) share /= 1.0 - f;
    }
    return vec2(same_side ? b : -b, share * 0.5 * squares / annulus);
}

// The ways that have a closed form, of far drops: the reflection outside, and straight through.
const uint CLOSED_WAYS = 3u;

// The sine of the largest angular radius of which they are exact enough.
float far_sine() {
    return min(1.0 / 30.0, 2.0 / 15.0 * (1.0 - 1.0 / lowest_index()));
}

// Does what `image_of` does, for one of them: the drop turns light by Φ' = π - 2θ outside, and by Φ' = 2θ - 2θt straight through, which
// leads to tan θt = sin(Φ'/2) / (n - cos(Φ'/2)). By the ray's angle α the camera's Φ is a little more, or less; two passes
// find it, with b within 3e-4 by estimate.
vec2 far_image_of(uint way, float off, float sine) {
    bool outside = way == 0u;
    float side = outside ? -1.0 : 1.0, turn = off, b = 0.0, c = 1.0, apart = 1.0;
    for (uint i = 0u; i < 3u; ++i) {
        turn = clamp(off + side * sine * b, 0.0, HALF_TURN);
        c = cos(0.5 * turn);
        apart = 1.0 + WATER * WATER - 2.0 * WATER * c;
        b = outside ? c : WATER * sqrt((1.0 - c) * (1.0 + c) / apart);
    }
    if (outside ? REFLECTION == 0u : WATER * c <= 1.0) return vec2(0.0);
    b = min(b, 0.99999);
    float cos_incidence = sqrt((1.0 - b) * (1.0 + b));
    float f = reflectance(Intersection(vec3(0.0), vec3(0.0), b, cos_incidence));
    // Half of d(b²) / d(cos Φ'), then from Φ' to Φ.
    float light = outside ? 0.25 * f
        : 0.25 * (1.0 - f) * (1.0 - f) * WATER * WATER * (WATER * c - 1.0) * (WATER - c) / (c * apart * apart);
    if (!outside && CONSERVING != 0u && INTERNAL_REFLECTIONS == 0u) light /= 1.0 - f;
    float slope = 2.0 - (outside ? 0.0 : 2.0 * cos_incidence * inversesqrt(WATER * WATER - b * b));
    float seen = max(off, 1e-4);
    light *= sin(max(turn, 1e-4)) / sin(seen) * slope / max(slope - sine * cos_incidence, 1e-3);
    return vec2(outside ? b : -b, light);
}

// The image by a way of a disc in a drop that is near or far.
vec2 image_in(uint way, float off, float radius, float sine) {
    bool closed = sine < far_sine() && (CLOSED_WAYS >> way & 1u) != 0u;
    return closed ? far_image_of(way, off, sine) : image_of(way, off, radius, sine);
}

// Unit vector perpendicular to `axis` in the plane of `axis` and `toward`; any where they are parallel.
vec3 aside_of(vec3 axis, vec3 toward) {
    vec3 aside = toward - axis * dot(axis, toward);
    if (dot(aside, aside) < 1e-12) aside = abs(axis.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    return normalize(aside - axis * dot(axis, aside));
}

float angle_between(vec3 a, vec3 b) {
    return atan(length(cross(a, b)), dot(a, b));
}
#endif
