#ifndef STREAK_LAYER_LINKS_GLSL
#define STREAK_LAYER_LINKS_GLSL
// Enters streaks into the lists of the streak layer's cells.
#ifndef STREAK_LAYER_ACCESS
#define STREAK_LAYER_ACCESS
#endif
#include "motion.glsl"
#include "streak.glsl"
#include "streak_layer.glsl"

// A node that holds a streak, or a disc, packed.
void write_streak_node(uint node, float distance2, uvec2 at, uvec4 rest) {
    write_four(node, uvec4(floatBitsToUint(distance2), 0u, at));
    write_four(node + 4u, rest);
}

// A drop's streak, `blur` pixels out of focus. The outline's squares of half widths are those of an ellipse that reaches away from the picture's middle.
Streak streak_of_drop(Drop drop, Outline o, Path p, float blur, float distance2) {
    float radius2 = drop.radius * drop.radius, flat2 = drop.view.z * drop.view.z - radius2;
    float size = frame.image.z * drop.radius / flat2;
    vec2 along = normalize(p.way), n = size * vec2(-along.y, along.x), v = vec2(drop.view.x, -drop.view.y);
    float across2 = dot(n, v) * dot(n, v) + flat2 * dot(n, n);
    float area = 3.14159265 * o.radius * o.radius * p.larger * opacity_at(distance2);
    return streak_of(o.center, p.way, area, across2, blur * blur);
}

// Cells that a streak may meet: from the first along its longer axis on, `across` of them each.
struct StreakCells {
    uint kind, first, rows, across;
};

uint kind_of_streak(Streak s) {
    bool is_short = s.full + s.ends <= SHORT_STREAK;
    bool is_thin = s.area * min(0.75 * s.inverse, 1.0) <= THIN * max(s.full, s.ends);
    return abs(s.slope) > SLANT || is_short && !(s.upright && is_thin) ? SQUARES
        : is_short ? SHORT_COLUMNS : s.upright ? COLUMNS : ROWS;
}

StreakCells cells_met(Streak s, uint kind) {
    StreakCells c;
    c.kind = kind;
    vec2 origin = vec2(first_tile() * TILE), at = s.center - origin;
    vec2 size = vec2(CELLS_PX[c.kind]);
    ivec2 count = ivec2(cells_of(c.kind));
    float along = s.upright ? at.y : at.x, cell = s.upright ? size.y : size.x, half_length = 0.5 * (s.full + s.ends);
    int most = s.upright ? count.y : count.x;
    int first = clamp(int(floor((along - half_length) / cell)), 0, most);
    int last = clamp(int(floor((along + half_length) / cell)), -1, most - 1);
    float aside = s.upright ? size.x : size.y, width = 2.0 / s.inverse + 1.0;
    c.first = uint(first);
    c.rows = uint(max(last - first + 1, 0));
    int least = s.upright ? count.x : count.y;
    c.across = min(uint((width + abs(s.slope) * cell) / aside) + 2u, uint(least));
    return c;
}

// Enters the streak of a record; `link`: the first of as many links as it may meet cells.
void enter_streak(uint record, Streak s, StreakCells c, uint link) {
    vec2 at = s.center - vec2(first_tile() * TILE), size = vec2(CELLS_PX[c.kind]);
    ivec2 count = ivec2(cells_of(c.kind));
    float along = s.upright ? at.y : at.x, off = s.upright ? at.x : at.y;
    float cell = s.upright ? size.y : size.x, aside = s.upright ? size.x : size.y;
    float half_width = 1.0 / s.inverse + 0.5, half_length = 0.5 * (s.full + s.ends);
    int least = s.upright ? count.x : count.y;
    uint heads = first_cell(c.kind), links = STREAK_HEADS;
    for (uint row = 0u; row < c.rows; ++row) {
        float from = max(float(c.first + row) * cell - along, -half_length);
        float to = min(float(c.first + row + 1u) * cell - along, half_length);
        float a = off + s.slope * from, b = off + s.slope * to;
        int first = clamp(int(floor((min(a, b) - half_width) / aside)), 0, least);
        int last = min(clamp(int(floor((max(a, b) + half_width) / aside)), -1, least - 1), first + int(c.across) - 1);
        for (int i = first; i <= last; ++i) {
            uvec2 place = s.upright ? uvec2(i, c.first + row) : uvec2(c.first + row, i);
            uint head = heads + place.y * uint(count.x) + place.x, word = links + 2u * link;
            streak_layer[word] = record;
            streak_layer[word + 1u] = atomicExchange(streak_layer[head], link);
            ++link;
        }
    }
}
#endif
