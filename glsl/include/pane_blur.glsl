#ifndef PANE_BLUR_GLSL
#define PANE_BLUR_GLSL
// The light of a pane's drops that are out of focus, in a pixel: of each the part of the lens from which it is met, times the mean of
// what is seen of it from there. Drops do not overlap, so their parts add up.
#include "pane.glsl"
#include "pane_drops.glsl"
#include "pane_looks.glsl"
#include "shared_halves.glsl"

// What of a pixel's rays drops that are out of focus take, their light, the nearest of them, and whether there are others.
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

// Adds a drop. `to_lens`: from the wet face to the lens, in whose unit disc rays are; `middle` of them is here.
void add_blurred(inout Blurred sum, uint number, PaneLook look, vec2 at, vec2 middle, mat2 to_lens) {
    float scale = sqrt(abs(determinant(to_lens))), part = covered_part(length(to_lens * (look.middle - middle)), scale * sqrt(look.area / 3.14159265));
    vec3 color = look.color;
    uint turns = look.kind == BY_PICTURE ? PANE_PLACES : 0u;
    // Rays meet a place fully or in part, as they begin within the lens or at its edge.
    float edge = 0.75 * scale * look.spacing, weights = 0.0;
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < turns; ++i) {
        vec4 seen = halves_of(seen_at(number * PANE_PLACES + i));
        float far = length(to_lens * (at + place_in_look(look, i) - middle));
        float weight = seen.a * clamp((1.0 + edge - far) / (2.0 * edge), 0.0, 1.0);
        light += weight * seen.rgb;
        weights += weight;
    }
    if (turns > 0u) part = weights * scale * scale * look.spacing * look.spacing / 3.14159265;
    if (weights > 0.0) color = light / weights;
    sum.light += part * color;
    sum.share += part;
    if (PANE_NEAREST != 0u && part > 0.0) sum.cap = nearer_cap(sum.cap, number);
}

// All drops that a pixel's rays may meet.
Blurred blurred_drops(vec2 pixel) {
    Blurred sum = Blurred(vec3(0.0), 0.0, NO_CAP, false);
    PaneRay ray = pane_ray(pixel, vec2(0.0), 0.5);
    if (ray.direction.z <= 0.0) return sum;
    vec2 middle = wet_place(ray), slope = ray.direction.xy / ray.direction.z;
    mat2 lens = lens_on_pane(pixel), step = pixel_on_pane(pixel);
    // The pixel itself spreads its rays, too.
    lens *= sqrt(1.0 + abs(determinant(step)) / (3.14159265 * max(abs(determinant(lens)), 1e-30)));
    mat2 to_lens = inverse(lens);
    float around = 1.1 * (length(vec4(lens[0], lens[1])) + length(vec4(step[0], step[1])));
    vec2 way = length(ray.direction.xy) > pane.overhang ? pane.tallest * slope : vec2(0.0);
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
            if (!is_first || !may_touch(cap, middle, slope, around)) continue;
            PaneLook look = look_at(number);
            if (look.kind == BY_RAYS) sum.has_sharp = true; else add_blurred(sum, number, look, cap.at, middle, to_lens);
        }
    }
    return sum;
}
#endif
