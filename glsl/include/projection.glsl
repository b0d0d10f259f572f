#ifndef PROJECTION_GLSL
#define PROJECTION_GLSL
// Between directions in view space and pixels; the same as src/scene/projection.rs.
//
// Pixels are told in the whole picture, whichever part of it is drawn: so a part has the bits of the whole. A point of
// the image plane is told from the view axis, in pixels, right and down.
#include "frame.glsl"

vec2 pixel_of(vec2 plane) {
    return frame.principal.xy + plane;
}

vec2 plane_of(vec2 pixel) {
    return pixel - frame.principal.xy;
}

// Normalised device coordinates in the part that is drawn.
vec2 device_of(vec2 plane) {
    return plane / (0.5 * vec2(frame.window.zw)) + frame.principal.zw;
}

// In view space, from the camera to the image plane, as long as that is.
vec3 ray_through(vec2 pixel) {
    vec2 plane = plane_of(pixel);
    return vec3(plane.x, -plane.y, -frame.image.z);
}
#endif
