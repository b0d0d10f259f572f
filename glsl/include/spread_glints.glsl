#ifndef SPREAD_GLINTS_GLSL
#define SPREAD_GLINTS_GLSL
// Which drops out of focus show the images of bright sources all over their discs.
#include "lens.glsl"

// Are places of the lens, each for itself, worth a look at a drop? They see other images in a near one. Spots of all sources together take
// time by the squared pixels of their drop's `disc`, that of its centre.
bool is_seen_by_places(vec4 sphere, float disc) {
    const float NEAR = 0.05, MOST_PIXELS2 = 8000.0;
    return frame.lens.x > NEAR * length(sphere.xyz) && float(source_count.x) * disc * disc < MOST_PIXELS2;
}

// Are the images of bright sources in a drop by rays spread evenly over its disc? They are where the lens's disc is larger than the drop,
// or its way is, which could not be told from spots of their own. In a near drop they are anything but even.
bool has_spread_glints(uint drop, vec4 sphere) {
    vec4 move = moves[2u * drop];
    float pixels = frame.image.z * sphere.w / max(-sphere.z, sphere.w);
    bool is_wide = dot(move.xyz, move.xyz) > 4.0 * sphere.w * sphere.w || move.w > 2.0 * pixels;
    return move.w > 0.0 && is_wide && !is_seen_by_places(sphere, moves[2u * drop + 1u].z);
}

// Are the images in a drop that is no sphere drawn one by one? Wider spots would take too long; then its rays meet the sources themselves.
bool has_own_spots(uint drop) {
    const float MOST_PIXELS2 = 50000.0;
    vec4 move = moves[2u * drop + 1u];
    float wide = move.z + 0.5 * max(abs(move.x), abs(move.y));
    return moves[2u * drop].w <= 0.0 || float(source_count.x) * wide * wide < MOST_PIXELS2;
}
#endif
