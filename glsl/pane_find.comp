#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// The pixels that drops of a pane may touch: one invocation a pixel, one workgroup for each block of them that drops may touch. COARSE:
// these, one invocation a block. See src/passes/pane/mod.rs.
#include "pane.glsl"
#include "pane_drops.glsl"
#include "pane_pictures.glsl"
#include "divided.glsl"
#include "together.glsl"

layout(local_size_x = 64) in;

const uint GROUPS_A_ROW = 32768u; // of an indirect dispatch

#ifdef COARSE
const uint LIST = 0u, A_GROUP = 1u;
#else
const uint LIST = 1u, A_GROUP = 64u; // pixels of a workgroup of pane_rays.comp
#endif

// Notes what drops touch in a list that begins at `from`.
void note(bool is_noted, uint what, uint from) {
    uvec4 noted = subgroupBallot(is_noted);
    uint count = subgroupBallotBitCount(noted), before = subgroupBallotExclusiveBitCount(noted), at = 0u;
    bool leads = subgroupElect();
    TAKE_TOGETHER(lists[LIST].count, count, leads, at);
    if (leads && count > 0u) {
        uint groups = (at + count + A_GROUP - 1u) / A_GROUP;
        atomicMax(lists[LIST].groups.x, min(groups, GROUPS_A_ROW));
        atomicMax(lists[LIST].groups.y, (groups + GROUPS_A_ROW - 1u) / GROUPS_A_ROW);
    }
    if (is_noted) touched[from + at + before] = what;
}

// Whether drops may be met by rays that leave the glass so near to a place: of the drops in the cells around it.
bool is_touched(Footprint f, float around) {
    vec2 way = way_over(f);
    vec2 low = min(f.place, f.place + way) - around, high = max(f.place, f.place + way) + around;
    vec2 end = pane.cell * vec2(pane.cells);
    bool found = false;
    if (any(lessThan(high, vec2(0.0))) || any(greaterThan(low, end))) return false;
    uvec2 first = cell_of(low), last = cell_of(high);
    for (uint y = first.y; y <= last.y && !found; ++y) {
        // A row's cells are one after the other.
        uint from = caps_of(uvec2(first.x, y)).x, to = caps_of(uvec2(last.x, y)).y;
        for (uint i = from; i < to && !found; ++i) found = may_touch(cap_at(cell_word(i)), f.place, f.slope, around);
    }
    return found;
}

void main() {
    uvec2 size = frame.window.zw, blocks = (size + PANE_BLOCK - 1u) / PANE_BLOCK;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, lane = gl_LocalInvocationID.x, pixels = size.x * size.y;
#ifdef COARSE
    uint number = group * gl_WorkGroupSize.x + lane;
    bool is_there = number < blocks.x * blocks.y;
    vec2 middle = (vec2(divided(number, blocks.x).yx) + 0.5) * float(PANE_BLOCK);
    float wide = float(PANE_BLOCK);
#else
    bool is_listed = group < lists[0].count;
    uint block = touched[pixels + (is_listed ? group : 0u)];
    uvec2 at = divided(block, blocks.x).yx * PANE_BLOCK + uvec2(lane % PANE_BLOCK, lane / PANE_BLOCK);
    bool is_there = is_listed && all(lessThan(at, size));
    uint number = at.y * size.x + at.x;
    vec2 middle = vec2(at) + 0.5;
    float wide = 1.0;
#endif
    Footprint f = footprint_of(vec2(frame.window.xy) + middle);
    // Where the pane is seen nearly edge on, nothing is known of where rays leave it.
    bool is_edge = abs(f.cosine) <= 2.0 * other_cosines(wide), meets = f.cosine > 0.0;
    // Where other rays have another slope, their way over the pane is another, too.
    float around = (1.0 + pane.tallest / -pane.eye.z) * around_of(f, wide);
    bool touches = is_there && (is_edge || meets && is_touched(f, around));
#ifdef COARSE
    note(touches, number, pixels);
#else
    note(touches, number, 0u);
#endif
}
