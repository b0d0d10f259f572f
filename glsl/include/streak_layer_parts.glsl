#ifndef STREAK_LAYER_PARTS_GLSL
#define STREAK_LAYER_PARTS_GLSL
// Enters streaks of which a bright source draws lines, part by part, for lines.comp.
#ifndef STREAK_LAYER_ACCESS
#define STREAK_LAYER_ACCESS
#endif
#include "streak.glsl"
#include "together.glsl"
#include "streak_layer.glsl"

void enter_parts(uint record, Streak s, bool has_lines) {
    vec2 from = vec2(first_tile() * TILE), to = vec2(end_tile() * TILE);
    float along = s.upright ? s.center.y : s.center.x, half_length = 0.5 * (s.full + s.ends);
    float begin = s.upright ? from.y : from.x, end = s.upright ? to.y : to.x;
    uint first = uint(clamp(along - half_length, begin, end)) / LINE_PART;
    uint after = uint(ceil(clamp(along + half_length, begin, end) / float(LINE_PART)));
    uint count = has_lines && after > first ? after - first : 0u, all_here = subgroupAdd(count), place = 0u;
    uint before = subgroupExclusiveAdd(count);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.line_parts, all_here, leads, place);
    STAY_BEYOND(totals.line_parts, LINE_PARTS, leads, place);
    if (all_here == 0u) return;
    if (leads) atomicMax(totals.line_groups.x, (min(place + all_here, LINE_PARTS) + 63u) / 64u);
    place += before;
    if (count > 0u && (place > LINE_PARTS || place + count > LINE_PARTS)) {
        atomicAdd(counters.lost, 1u);
        atomicOr(totals.lacks_room, 1u);
        count = 0u;
    }
    for (uint i = 0u; i < count; ++i) {
        streak_layer[line_part(place + i)] = record;
        streak_layer[line_part(place + i) + 1u] = first + i;
    }
}
#endif
