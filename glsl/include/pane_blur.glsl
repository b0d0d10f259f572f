#ifndef PANE_BLUR_GLSL
#define PANE_BLUR_GLSL
// The light of a pane's drops that are out of focus, in a pixel: of each the part of the pixel's rays that meet it, times the mean of
// what these see of it. Drops do not overlap, so their parts add up.
#include "pane.glsl"
#include "pane_drops.glsl"
#include "pane_looks.glsl"
#include "shared_halves.glsl"

// What of a pixel's rays these drops take, their light, the nearest of them, and whether there are others.
struct Blurred {
    vec3 light;
    float share;
    uint cap;
    bool has_sharp;
};

// Share of the unit disc that a disc of radius r at a distance covers.
float covered_part(float apart, float r) {
    if (apart >= 1.0 + r) return 0.0;
    float all = min(1.0, r * r);
    if (apart <= abs(1.0 - r)) return all;
    float a = (apart * apart + 1.0 - r * r) / (2.0 * apart), b = apart - a;
    float wide = sqrt(max(1.0 - a * a, 0.0));
    float sum = atan(wide, a) + r * r * atan(wide, b) - apart * wide;
    return clamp(sum / 3.14159265, 0.0, all);
}

// The sums of a drop's picture over the places that rays meet around `middle`: between four entries of its table, and the bright ones.
vec4 picture_around(uint number, PaneLook look, PaneCap cap, vec2 middle, mat2 to_disc) {
    uint edge = table_edge(look);
    vec2 aside = to_disc * (middle - cap.at - look.from);
    vec2 at = clamp(0.5 * aside / look.reach + 0.5, vec2(0.0), vec2(1.0)) * float(edge - 1u);
    uvec2 first = min(uvec2(at), uvec2(edge - 2u));
    vec2 share = at - vec2(first);
    uint from = number * PANE_WORDS + PANE_PLACES + first.y * edge + first.x;
    vec4 upper = mix(halves_of(seen_at(from)), halves_of(seen_at(from + 1u)), share.x);
    vec4 lower = mix(halves_of(seen_at(from + edge)), halves_of(seen_at(from + edge + 1u)), share.x);
    vec4 seen = mix(upper, lower, share.y);
    for (uint bright = look.bright; (bright & 0xffu) != 0xffu; bright = bright >> 8 | 0xff000000u) {
        vec3 light = halves_of(seen_at(number * PANE_WORDS + (bright & 0xffu))).rgb;
        seen.rgb += weight_of(look, to_disc, aside, bright & 0xffu) / float(PANE_PLACES) * light;
    }
    return seen;
}

// Adds a drop. A pixel's rays are a disc around `middle` on the wet face; `to_disc` makes it the unit disc.
void add_look(inout Blurred sum, uint number, PaneLook look, PaneCap cap, vec2 middle, mat2 to_disc) {
    float area = abs(determinant(to_disc)), part = covered_part(length(to_disc * (look.middle - middle)), sqrt(area * look.area / 3.14159265));
    vec3 color = look.color;
    if (look.kind != BY_COLOR) {
        vec4 seen = picture_around(number, look, cap, middle, to_disc);
        if (seen.a > 0.0) color = seen.rgb / seen.a;
        // Over the sum of a place's weights on all the wet face, in discs, as places are met in part around their edge.
        float edge = soft_edge(look, to_disc), discs = 1.0 + edge * edge / 3.0;
        part = min(seen.a * float(PANE_PLACES) * area * look.spacing * look.spacing / (3.14159265 * discs), 1.0);
    }
    sum.light += part * color;
    sum.share += part;
    if (PANE_NEAREST != 0u && part > 0.0) sum.cap = nearer_cap(sum.cap, number);
}

// All drops that a pixel's rays may meet.
Blurred blurred_drops(vec2 pixel) {
    Blurred sum = Blurred(vec3(0.0), 0.0, NO_CAP, false);
    Footprint f = footprint_of(pixel);
    if (f.cosine <= 0.0) return sum;
    vec2 middle = f.place, slope = f.slope, way = way_over(f);
    mat2 to_disc = inverse(rays_on_pane(f));
    float around = around_of(f, 1.0);
    vec2 low = min(middle, middle + way) - around, high = max(middle, middle + way) + around;
    uvec2 first = cell_of(low), last = cell_of(high);
    for (uint y = first.y; y <= last.y; ++y) {
        uint from = caps_of(uvec2(first.x, y)).x, to = caps_of(uvec2(last.x, y)).y;
        for (uint i = from; i < to; ++i) {
            uint number = cell_word(i);
            PaneCap cap = cap_at(number);
            // A drop is in several cells: it is taken in the first of those that are looked into.
            uvec2 of_cap = max(cell_of(cap.at - cap.reach), first);
            uvec2 others = caps_of(uvec2(of_cap.x, y));
            bool is_first = of_cap.y == y && i >= others.x && i < others.y;
            // A loop of one turn or none: CPU drivers run a branch that no lane takes.
            uint turns = is_first && may_touch(cap, middle, slope, around) ? 1u : 0u;
            for (uint turn = 0u; turn < turns; ++turn) {
                PaneLook look = look_at(number);
                if (look.kind == BY_RAYS) sum.has_sharp = true; else add_look(sum, number, look, cap, middle, to_disc);
            }
        }
    }
    return sum;
}
#endif
