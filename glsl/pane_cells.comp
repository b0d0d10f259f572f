#version 460
#extension GL_GOOGLE_include_directive : require
// A host's drops on a pane, and the cells of a grid by which rays find them, as src/passes/pane/drops.rs makes them of a scene's.
// Caps, and how many drops each cell has: one invocation a drop. STARTS: where each cell's begin, one workgroup a row of cells.
// FILL: their numbers, as they come; and ORDER: rising; one invocation a drop. See src/passes/pane/host.rs.
#define PANE_ACCESS
#include "constants.glsl"
#include "counters.glsl"
#include "host_records.glsl"
#include "pane.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform PaneCellsPush {
    vec2 low;             // drops at a smaller place are left out
    vec2 high;            // and those at a larger one
    vec2 corner;          // of the grid
    float largest_radius; // those that are larger are left out, too
    float largest_angle;  // and those that are steeper, in degrees
    float contact_angle;  // of drops that have none of their own
    uint start;           // word of the first drop in its buffer
    uint stride;          // words from one drop to the next
    uint at;              // words from a drop's start; NOTHING: they have none
    uint radius;
    uint angle;
    uint count;           // drops
    uint count_at;        // word of their count in its buffer; NOTHING: it is `count`
    uint capacity;        // drops that the buffer holds, at most `most`
    uint most;            // those that there are places for
} push;

// First and last cell of each drop; of one that is in none the last is before the first.
layout(std430, set = 0, binding = 6) buffer PaneSpans { uvec4 spans[]; };
// How many drops each cell has, then each row of cells. From STARTS on, up to where the drops of a cell that are not yet filled in
// have their places; NOTHING: it has no room.
layout(std430, set = 0, binding = 7) buffer PaneTallies { uint tallies[]; };
layout(std430, set = 0, binding = 8) buffer PaneUnordered { uint unordered[]; };
// Groups of the dispatches that find what drops look like: an invocation for each of 64 places of a drop, and one a drop.
layout(std430, set = 0, binding = 9) writeonly buffer PaneGroups { uvec4 look_groups[2]; };
const uint GROUPS_A_ROW = 32768u; // of such a dispatch

// Words before the cells' numbers, and the room for these.
uint first_word() {
    return pane.cells.x * pane.cells.y + 1u;
}

uint room() {
    return PANE_LIST * push.most;
}

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

#ifdef STARTS
shared uint of_lanes[gl_WorkGroupSize.x], of_rows[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationID.x, lanes = gl_WorkGroupSize.x, row = gl_WorkGroupID.x, across = pane.cells.x;
    uint a_lane = (across + lanes - 1u) / lanes, first = min(lane * a_lane, across), last = min(first + a_lane, across);
    uint sum = 0u, before = 0u;
    for (uint x = first; x < last; ++x) sum += tallies[row * across + x];
    for (uint y = lane; y < row; y += lanes) before += tallies[pane.cells.y * across + y];
    of_lanes[lane] = sum;
    of_rows[lane] = before;
    barrier();
    uint end = 0u;
    for (uint other = 0u; other < lanes; ++other) end += of_rows[other] + (other < lane ? of_lanes[other] : 0u);
    for (uint x = first; x < last; ++x) {
        uint cell = row * across + x, begin = end;
        end += tallies[cell];
        bool fits = end <= room();
        cells[cell] = first_word() + min(begin, room());
        if (cell + 2u == first_word()) cells[cell + 1u] = first_word() + min(end, room());
        tallies[cell] = fits ? end : NOTHING;
        // What is left of the room in the first cell that has too little has the number of no drop.
        for (uint i = begin; i < room() && !fits; ++i) cells[first_word() + i] = push.most;
    }
}
#elif defined(FILL) || defined(ORDER)
void main() {
    uint number = invocation();
    if (number >= push.most) return;
    uvec4 span = spans[number];
    for (uint y = span.y; y <= span.w; ++y) {
        for (uint x = span.x; x <= span.z; ++x) {
            uint cell = y * pane.cells.x + x;
#ifdef FILL
            uint end = atomicAdd(tallies[cell], 0xffffffffu);
            if (end <= room()) unordered[end - 1u] = number; else atomicAdd(counters.lost, 1u);
#else
            if (tallies[cell] > room()) continue;
            uint from = cells[cell] - first_word(), to = cells[cell + 1u] - first_word(), place = cells[cell];
            for (uint i = from; i < to; ++i) place += uint(unordered[i] < number);
            cells[place] = number;
#endif
        }
    }
}
#else
// Tangent of half an angle up to 170 degrees, by the series of sine and cosine of a quarter of it: a driver's own sine may be off by
// 2^-11.
float half_tangent(float degrees) {
    float x = radians(0.25 * degrees), x2 = x * x;
    float sine = x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0))));
    float cosine = 1.0 - x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0 * (1.0 - x2 / 90.0))));
    return 2.0 * sine * cosine / (1.0 - 2.0 * sine * sine);
}

// Makes what `Cap` of src/optics/cap.rs has.
PaneCap cap_of(vec2 at, float radius, float angle, uint number) {
    float t = half_tangent(angle), sphere = radius * (1.0 + t * t) / (2.0 * t), center = -radius * (1.0 - t * t) / (2.0 * t);
    return PaneCap(at, radius, angle > 90.0 ? sphere : radius, radius * t, sphere, center, number);
}

void main() {
    uint number = invocation(), claimed = claimed_count(push.count, push.count_at), count = min(claimed, push.capacity);
    if (number == 0u) {
        atomicAdd(counters.beyond, claimed - count);
        uvec2 groups = uvec2(count, (count + 63u) / 64u), rows = (groups + GROUPS_A_ROW - 1u) / GROUPS_A_ROW;
        for (uint i = 0u; i < 2u; ++i) look_groups[i] = uvec4(min(groups[i], GROUPS_A_ROW), rows[i], 1u, 0u);
    }
    if (number > push.most) return;
    // A cap that no ray meets, in no cell: in the place of what is no drop, and after the last.
    caps[number] = PaneCap(vec2(-1e15), 0.0, 0.0, 0.0, 0.0, 0.0, number);
    spans[number] = uvec4(1u, 1u, 0u, 0u);
    if (number >= count) return;
    uint record = push.start + number * push.stride;
    vec2 at = uintBitsToFloat(uvec2(particles[record + push.at], particles[record + push.at + 1u]));
    float radius = uintBitsToFloat(particles[record + push.radius]), angle = push.contact_angle;
    if (push.angle != NOTHING) angle = uintBitsToFloat(particles[record + push.angle]);
    bool is_within = all(lessThanEqual(push.low, at)) && all(lessThanEqual(at, push.high));
    bool has_size = radius > 0.0 && radius <= push.largest_radius && angle >= 1.0 && angle <= push.largest_angle;
    if (!(is_finite(vec3(at, radius)) && is_finite(vec3(angle)) && is_within && has_size)) {
        atomicAdd(counters.unfit, 1u);
        return;
    }
    PaneCap cap = cap_of(at - push.corner, radius, angle, number);
    // Wider than the drop by more than float32 loses of places.
    float reach = cap.reach + 1e-3 * pane.cell;
    uvec4 span = uvec4(cell_of(cap.at - reach), cell_of(cap.at + reach));
    caps[number] = cap;
    spans[number] = span;
    for (uint y = span.y; y <= span.w; ++y) {
        atomicAdd(tallies[pane.cells.x * pane.cells.y + y], span.z - span.x + 1u);
        for (uint x = span.x; x <= span.z; ++x) atomicAdd(tallies[y * pane.cells.x + x], 1u);
    }
}
#endif
