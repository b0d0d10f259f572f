#ifndef FLAT_RAIN_GLSL
#define FLAT_RAIN_GLSL
// Far rain whose drops are flattened (src/passes/flat_light.rs).
#include "appearance.glsl"
#include "flattened.glsl"
#include "splat_table.glsl"

layout(constant_id = 25) const uint FLAT_RAIN = 0; // 1: there is rain, and its drops are drawn flattened
layout(constant_id = 29) const uint FLAT_PLACED = 0; // 1: drops placed by hand are, and shown by pictures

// Whether the splats' table has what flattened drops show.
bool has_flat() {
    return FLAT_RAIN != 0u || FLAT_PLACED != 0u;
}

// Where it has what the drops of a scene together show in a direction: as a medium, and drops that are shown one by one.
uint flat_rain_entry(uint texel) {
    return uint(splat_table.length()) - SINGLE_TEXELS + texel;
}
#endif
