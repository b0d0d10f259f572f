#ifndef RAIN_GLSL
#define RAIN_GLSL
// Where a drop is and whether it is in view; the same as src/rain/mod.rs and src/rain/cull.rs, bit for bit.
// `precise` keeps every product and sum apart, so that each rounds as the CPU's does.
#include "frame.glsl"
#include "pcg4d.glsl"
#include "placed_boxes.glsl"

layout(constant_id = 21) const uint SEVERAL = 0; // 1: there are several populations of drops in boxes

// Population `number` of the drops in boxes. Without SEVERAL there is but the first.
Population population_numbered(uint number) {
    Population p = Population(frame.units, uvec4(frame.camera_place.xyz, 0u), frame.shift, frame.seed, frame.moved);
    if (SEVERAL != 0u && number > 0u) p = others[number - 1u];
    return p;
}

// Number of the population that a drop is of: their drops follow one another.
uint population_number(uint index) {
    uint number = 0u;
    for (uint i = 0u; SEVERAL != 0u && i < MOST_POPULATIONS - 1u; ++i) {
        number += index >= others[i].camera_place.w ? 1u : 0u;
    }
    return number;
}

// Place at tick 0.
uvec3 start(Population p, uint index) {
    return pcg4d(uvec4(index - p.camera_place.w, p.seed.xy, 0x7261696eu)).xyz;
}

// A drop in its box: centre relative to the camera along the world's axes, and radius.
vec4 drop_at(Population p, uint index) {
    ivec3 place = ivec3(start(p, index) + p.shift.xyz - p.camera_place.xyz);
    precise vec3 relative = vec3(place) * p.units.xyz;
    return vec4(relative, p.units.w);
}

vec3 relative_placed(Placed drop) {
    precise vec3 relative =
        (drop.high.xyz - frame.camera_high.xyz) + (drop.low.xyz - frame.camera_low.xyz);
    return relative;
}

vec3 view_space(vec3 p) {
    precise vec3 v = vec3(
        (frame.right.x * p.x + frame.right.y * p.y) + frame.right.z * p.z,
        (frame.up.x * p.x + frame.up.y * p.y) + frame.up.z * p.z,
        (frame.back.x * p.x + frame.back.y * p.y) + frame.back.z * p.z);
    return v;
}

const uint OUT_OF_VIEW = 0, VISIBLE = 1, CAMERA_INSIDE = 2, BESIDE_CAMERA = 3;

// What becomes of a drop with its centre at `v` in view space, which is seen across the view axis as far as `reach` from
// there; `distance2` is its square's length.
uint visibility(vec3 v, float radius, float reach, out float distance2) {
    precise float depth = -v.z;
    precise float square = (v.x * v.x + v.y * v.y) + v.z * v.z;
    precise float radius2 = radius * radius;
    precise float beyond_left = -v.x * frame.frustum_x.x - depth * frame.frustum_x.y;
    precise float beyond_right = v.x * frame.frustum_x.z - depth * frame.frustum_x.w;
    precise float beyond_top = v.y * frame.frustum_y.x - depth * frame.frustum_y.y;
    precise float beyond_bottom = -v.y * frame.frustum_y.z - depth * frame.frustum_y.w;
    precise float near2 = frame.camera_high.w * frame.camera_high.w;
    distance2 = square;
    if (square <= radius2) return CAMERA_INSIDE;
    bool in_frustum = max(beyond_left, beyond_right) <= reach && max(beyond_top, beyond_bottom) <= reach;
    if (!in_frustum || square < near2 || depth <= -radius) return OUT_OF_VIEW;
    return depth <= radius ? BESIDE_CAMERA : VISIBLE;
}

// A pinhole sees a drop across the view axis by its radius.
uint visibility(vec3 v, float radius, out float distance2) {
    return visibility(v, radius, radius, distance2);
}
#endif
