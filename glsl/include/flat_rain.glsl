#ifndef FLAT_RAIN_GLSL
#define FLAT_RAIN_GLSL
// Far rain whose drops are flattened (src/passes/flat_light.rs).
#include "appearance.glsl"
#include "splat_table.glsl"

layout(constant_id = 25) const uint FLAT_RAIN = 0; // 1: there is rain, and its drops are drawn flattened

// By how much a drop of a diameter in mm is lower than wide (src/rain/shape.rs: Beard and Chuang 1987).
float flatness_of(float mm) {
    float d = min(mm, 6.0);
    return d > float(SMALLEST_MM) ? -4.8e-3 - d * (5.7e-4 + d * (-2.628e-2 + d * (3.682e-3 - d * 1.677e-4))) : 0.0;
}

// Which of the diameters of flattened drops, 3 and 6 mm, splats are between: by number, and their flatness.
const uvec2 FLAT_SPLATS = uvec2(1u, 3u);
const vec2 FLATNESS = vec2(0.1442, 0.3599);

// Where the splats' table has what flattened rain shows in a direction: as a medium, and drops that are shown one by one.
uint flat_rain_entry(uint texel) {
    return uint(splat_table.length()) - SINGLE_TEXELS + texel;
}
#endif
