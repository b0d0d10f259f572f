#ifndef SPREAD_GLINTS_GLSL
#define SPREAD_GLINTS_GLSL
// Which drops out of focus show the images of bright sources all over their discs.
#include "lens.glsl"

// Is a drop so near that places of the lens see other images in it?
bool is_wide_lens(vec4 sphere) {
    return frame.lens.x > 0.05 * length(sphere.xyz);
}

// Squared pixels up to which spots of all sources are drawn one by one in a near drop (glints.comp).
const float MOST_SPOTS = 15000.0;

// Are the images of bright sources in a drop by rays spread evenly over its disc? They are where the lens's disc is larger than the drop, or
// its way is, which could not be told from spots of their own. In a near drop they are anything but even.
bool has_spread_glints(uint drop, vec4 sphere) {
    vec4 move = moves[2u * drop];
    float disc = moves[2u * drop + 1u].z, pixels = frame.image.z * sphere.w / max(-sphere.z, sphere.w);
    bool is_wide = dot(move.xyz, move.xyz) > 4.0 * sphere.w * sphere.w || move.w > 2.0 * pixels;
    return move.w > 0.0 && is_wide && !(is_wide_lens(sphere) && float(source_count.x) * disc * disc < MOST_SPOTS);
}
#endif
