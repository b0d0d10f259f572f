#ifndef PANE_DROPS_GLSL
#define PANE_DROPS_GLSL
// Which drop of a pane a ray meets.
#include "pane.glsl"

// The first drop whose disc a place of the wet face is in.
uint cap_around(vec2 place) {
    if (!is_over_grid(place)) return NO_CAP;
    uvec2 range = caps_of(cell_of(place));
    uint found = NO_CAP;
    for (uint i = range.x; i < range.y && found == NO_CAP; ++i) {
        uint number = cell_word(i);
        PaneCap cap = cap_at(number);
        vec2 apart = place - cap.at;
        if (dot(apart, apart) < cap.radius * cap.radius) found = number;
    }
    return found;
}

const float NOWHERE = 1e30;

// How far along a ray that leaves the dry glass at a place a drop is met from outside; NOWHERE: not at all.
float distance_outside(PaneCap cap, vec2 place, vec3 d) {
    vec3 from = vec3(place - cap.at, -cap.center);
    float b = dot(from, d);
    vec3 miss = from - b * d;
    float half2 = cap.sphere * cap.sphere - dot(miss, miss), distance = -b - sqrt(max(half2, 0.0));
    return half2 > 0.0 && distance > 0.0 && distance * d.z > 0.0 ? distance : NOWHERE;
}

// The distances along a ray within which it is over the grid, no higher than the highest drop.
vec2 over_grid(vec2 place, vec3 d) {
    vec2 range = vec2(0.0, pane.tallest / d.z), to = pane.cell * vec2(pane.cells);
    for (uint axis = 0u; axis < 2u; ++axis) {
        vec2 edges = vec2(-place[axis], to[axis] - place[axis]);
        if (d[axis] == 0.0) {
            if (edges.x > 0.0 || edges.y < 0.0) range.y = -1.0;
            continue;
        }
        edges /= d[axis];
        range = vec2(max(range.x, min(edges.x, edges.y)), min(range.y, max(edges.x, edges.y)));
    }
    return range;
}

// The first drop that a ray from a place of the dry glass meets from outside, and how far along it: cell by cell.
uint cap_outside(vec2 place, vec3 d, out float nearest) {
    nearest = NOWHERE;
    uint found = NO_CAP;
    if (length(d.xy) <= pane.overhang) return found;
    vec2 range = over_grid(place, d);
    ivec2 cell = ivec2(cell_of(place + range.x * d.xy)), step = ivec2(greaterThan(d.xy, vec2(0.0))) * 2 - 1;
    float at = range.x;
    while (at <= range.y && nearest >= at) {
        uvec2 numbers = caps_of(uvec2(cell));
        for (uint i = numbers.x; i < numbers.y; ++i) {
            uint number = cell_word(i);
            float distance = distance_outside(cap_at(number), place, d);
            if (distance < nearest) {
                nearest = distance;
                found = number;
            }
        }
        vec2 edge = pane.cell * vec2(cell + max(step, 0)) - place;
        vec2 next = vec2(d.x == 0.0 ? NOWHERE : edge.x / d.x, d.y == 0.0 ? NOWHERE : edge.y / d.y);
        at = min(next.x, next.y);
        cell += next.x <= next.y ? ivec2(step.x, 0) : ivec2(0, step.y);
        if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, ivec2(pane.cells)))) at = NOWHERE;
    }
    return found;
}

// Which of two drops is nearer, by the planar depth of the middle of its disc, then by its number; either may be none.
uint nearer_cap(uint a, uint b) {
    if (a == b || a == NO_CAP || b == NO_CAP) return min(a, b);
    float nearer = dot(cap_at(b).at - cap_at(a).at, vec2(pane.u.z, pane.v.z));
    return nearer > 0.0 || nearer == 0.0 && b < a ? b : a;
}

// By how much the cosines of a pixel's rays may differ from that of its middle, or those of so many pixels along both axes.
float other_cosines(float pixels) {
    return pixels * (abs(pane.normal.x) + abs(pane.normal.y)) / frame.image.z + 1.5 * frame.lens.x * frame.lens.y;
}

// How far from the place of the middle such rays leave the glass, at most: by the derivatives there, which grow as the square of the
// cosine falls, and a tenth more. (No more than half of the cosine may fall.)
float around_of(Footprint f, float pixels) {
    float least = max(1.0 - other_cosines(pixels) / f.cosine, 0.5), wide = longest_axis(f.lens) + 0.70710678 * pixels * longest_axis(f.step);
    return 1.1 * wide / (least * least) + length(pane.motion);
}

// Along the pane, the way of a ray from there until it is above all drops; where it meets none from outside, none.
vec2 way_over(Footprint f) {
    bool may_meet = length(f.slope) * inversesqrt(1.0 + dot(f.slope, f.slope)) > pane.overhang;
    return may_meet ? pane.tallest * f.slope : vec2(0.0);
}

// Whether a drop may be met by rays that leave the glass so near to a place, with about this direction.
bool may_touch(PaneCap cap, vec2 place, vec2 slope, float around) {
    vec2 to_cap = cap.at - place, way = cap.height * slope;
    // The nearest point of the way over which the ray is no higher than the drop.
    float part = clamp(dot(to_cap, way) / max(dot(way, way), 1e-30), 0.0, 1.0);
    vec2 apart = to_cap - part * way;
    float reach = cap.reach + around;
    return dot(apart, apart) < reach * reach;
}
#endif
