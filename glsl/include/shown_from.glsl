#ifndef SHOWN_FROM_GLSL
#define SHOWN_FROM_GLSL
// From where a far drop's pictures are taken (src/passes/appearance.rs).
#include "octahedron.glsl"
#include "projection.glsl"
#include "tile_buffers.glsl"

// How far beyond the picture's edges directions have pictures, over the focal length: 3.9° at most, and the nearest of the map's is
// 3.8° off; appearance.comp has 8°.
const float BEYOND_PICTURE = 0.068;

// Number of the direction of a drop by its place from the camera, in world space (`d`, a unit vector) and in view space. A drop that
// moves, or is out of focus, may be seen although its place is far out of the picture: it is shown as from the edge.
uint shown_from(vec3 d, vec3 view) {
    if (is_spread()) {
        vec2 plane = vec2(view.x, -view.y) * (frame.image.z / max(-view.z, 1e-3 * length(view)));
        vec2 low = plane_of(vec2(0.0)) - BEYOND_PICTURE * frame.image.z, high = plane_of(frame.image.xy) + BEYOND_PICTURE * frame.image.z;
        vec2 held = clamp(plane, low, high);
        if (held != plane) {
            d = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * normalize(vec3(held.x, -held.y, -frame.image.z));
        }
    }
    return direction_texel(d);
}
#endif
