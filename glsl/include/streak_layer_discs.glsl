#ifndef STREAK_LAYER_DISCS_GLSL
#define STREAK_LAYER_DISCS_GLSL
// Drops out of focus in the lists of the streak layer's cells: discs, drawn out along their way if they move.
//
// They enter the lists by the same loops as streaks: llvmpipe 22.3.6 also runs the loops of a branch that no lane takes,
// and keeps what they exchange.
#include "disc.glsl"
#include "streak_layer_links.glsl"

// A drop with a longer way, in radii of its disc, is a streak as wide as the disc.
const float DISC_RADII = 3.0;
// Radius in pixels from which on a disc is in the lists of the wide squares.
const float WIDE_DISC_PX = 24.0;

// Is a drop of the streak layer a disc rather than a streak?
bool is_disc(Path p, float blur) {
    return blur > 0.0 && length(p.way) <= DISC_RADII * blur;
}

// A drop's disc; `opacity`: of the drop in focus.
Disc disc_of_drop(Outline o, Path p, float blur, float opacity) {
    Disc d;
    float length = length(p.way);
    d.center = o.center;
    d.radius = blur;
    d.along = length > 0.0 ? p.way / length : vec2(1.0, 0.0);
    // It has the variance of disc and way together.
    d.longer = length > 0.0 ? sqrt(1.0 + length * length / (3.0 * blur * blur)) : 1.0;
    // What its edge falls off over: of the variance of the drop and a pixel.
    d.edge = min(sqrt(3.0 * o.radius * o.radius + 1.0), 2.0 * blur);
    float area = blur * blur + d.edge * d.edge * (1.0 / 12.0);
    d.opacity = min(opacity * o.radius * o.radius * p.larger / (area * d.longer), 1.0);
    return d;
}

// Half the sides of the box around a disc.
vec2 box_of_disc(Disc d) {
    float wide = d.radius + 0.5 * d.edge;
    vec2 longer = d.along * (wide * d.longer), across = vec2(-d.along.y, d.along.x) * wide;
    return min(sqrt(longer * longer + across * across), MOST_BLUR_PX);
}

// Tells the kind of its cells.
uint kind_of_disc(Disc d) {
    vec2 box = box_of_disc(d);
    return max(box.x, box.y) > WIDE_DISC_PX ? WIDE_DISCS : DISCS;
}

// An upright streak that meets the cells that a disc meets.
Streak around_disc(Disc d) {
    vec2 box = box_of_disc(d);
    return Streak(d.center, 0.0, true, 0.0, 1.0 / max(box.x - 0.5, 0.1), 2.0 * box.y, 0.0, 0.0);
}
#endif
