#ifndef SHELTERED_MEDIUM_GLSL
#define SHELTERED_MEDIUM_GLSL
// What surfaces keep off of the medium, which falls as its drops do on the mean. Along a ray of the camera it is asked
// at some places whether they are sheltered; an edge between two of them is found by halving.
#include "medium.glsl"
#include "shelter.glsl"

// Places at most and at least, and what optical depth lies between two at most if these are enough.
const float SHELTER_PLACES = 32.0, FEWEST_PLACES = 2.0, BETWEEN_PLACES = 0.004;
// An edge is found within this optical depth, but after so many halvings in any case.
const float SHELTER_EDGE = 0.0005;
const uint SHELTER_HALVINGS = 6;

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
    float since = medium_depth(view, range.x).y, all = medium_depth(view, range.y).y - since, sum = 0.0;
    if (all < SHELTER_EDGE) return 0.0;
    float places = clamp(ceil(all / BETWEEN_PLACES), FEWEST_PLACES, SHELTER_PLACES), each = (range.y - range.x) / places;
    float fine = SHELTER_EDGE * (range.y - range.x) / all;
    bool was_under = is_sheltered(range.x * world, shelter.medium);
    for (float i = 1.0; i <= places; i += 1.0) {
        float high = range.x + each * i, low = high - each;
        bool is_under = is_sheltered(high * world, shelter.medium);
        if (is_under == was_under && i < places) continue;
        for (uint halving = 0u; halving < SHELTER_HALVINGS && is_under != was_under && high - low > fine; ++halving) {
            float middle = 0.5 * (low + high);
            bool is_low = is_sheltered(middle * world, shelter.medium) == was_under;
            low = is_low ? middle : low;
            high = is_low ? high : middle;
        }
        float until = medium_depth(view, high).y;
        if (was_under) sum += until - since;
        since = until;
        was_under = is_under;
    }
    return sum;
}
#endif
