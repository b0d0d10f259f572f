#ifndef SHELTERED_MEDIUM_GLSL
#define SHELTERED_MEDIUM_GLSL
// What surfaces keep off of the medium, which falls as its drops do on the mean. Along a ray of the camera it is asked
// at some places whether they are sheltered; an edge between two of them is found by halving.
#include "medium.glsl"
#include "shelter.glsl"

// Places at most and at least, and what optical depth lies between two at most if these are enough.
const float SHELTER_PLACES = 32.0, FEWEST_PLACES = 2.0, BETWEEN_PLACES = 0.008;
// An edge is the middle of a part of this optical depth, but of no smaller part between two places than this.
const float SHELTER_EDGE = 0.001, MOST_HALVED = 64.0;
// Instead of a distance: no edge is known.
const float BEYOND_EDGES = 1e30;

// The part of a ray beyond which nothing is sheltered: no farther beside the map than the lines lean below the highest surface,
// and below that.
vec2 within_shelter(vec3 world, float from, float to) {
    float below = -shelter.origin.y - shelter.origin.w;
    vec2 lean = abs(shelter.medium.xy) / shelter.scale.xy, first = shelter.origin.xz, last = first + shelter.scale.zw / shelter.scale.xy;
    // Each is offset + slope * distance <= 0.
    vec2 limits[5] = vec2[5](
        vec2(below, world.y),
        vec2(-last.x, world.x) + lean.x * vec2(below, world.y),
        vec2(first.x, -world.x) + lean.x * vec2(below, world.y),
        vec2(-last.y, world.z) + lean.y * vec2(below, world.y),
        vec2(first.y, -world.z) + lean.y * vec2(below, world.y));
    for (uint i = 0u; i < 5u; ++i) {
        float limit = -limits[i].x / (limits[i].y == 0.0 ? 1e-30 : limits[i].y);
        if (limits[i].y >= 0.0) to = min(to, limit);
        if (limits[i].y < 0.0) from = max(from, limit);
    }
    return vec2(from, to);
}

// Optical depth of what is sheltered along a unit direction, up to a distance.
float sheltered_depth(vec3 view, vec3 world, float distance) {
    vec2 range = within_shelter(world, 0.0, min(distance, field.medium.z));
    if (range.x >= range.y) return 0.0;
    float before = medium_depth(view, range.x).y, all = medium_depth(view, range.y).y - before, since = 0.0, sum = 0.0;
    if (all < SHELTER_EDGE) return 0.0;
    float places = clamp(ceil(all / BETWEEN_PLACES), FEWEST_PLACES, SHELTER_PLACES), each = (range.y - range.x) / places;
    float fine = max(SHELTER_EDGE * (range.y - range.x) / all, each / MOST_HALVED);
    // Shelter is at `low` as `was_under` says; an edge is before `high`, where that is not beyond all. Each round asks for one place:
    // a loop within would cost a CPU driver one round more for every place.
    float low = range.x, high = BEYOND_EDGES;
    bool was_under = false;
    for (float number = 0.0; number <= places;) {
        float at = high < BEYOND_EDGES ? 0.5 * (low + high) : range.x + each * number;
        bool is_under = is_sheltered(at * world, shelter.medium);
        if (number == 0.0) was_under = is_under;
        low = is_under == was_under ? at : low;
        high = is_under == was_under ? high : at;
        bool is_found = high - low <= fine;
        if (is_found) {
            float until = medium_depth(view, 0.5 * (low + high)).y - before;
            sum += was_under ? until - since : 0.0;
            since = until;
            was_under = !was_under;
            low = high;
            high = BEYOND_EDGES;
        }
        number += is_found || high == BEYOND_EDGES ? 1.0 : 0.0;
    }
    if (was_under) sum += all - since;
    return sum;
}
#endif
