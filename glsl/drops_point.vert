#version 460
#extension GL_GOOGLE_include_directive : require
// A drop as a point. See src/passes/drops.rs.
#include "frame.glsl"
#include "sprite.glsl"

// Scales the image's normalised device coordinates to those of the viewport, which is larger by a
// guard band so that no driver clips a point whose centre is just off the image.
layout(push_constant) uniform Push { vec2 viewport_scale; };

layout(location = 0) in vec4 drop; // centre in view space, radius; radius 0: nothing to draw
layout(location = 0) flat out mat3 rotation;
layout(location = 3) flat out vec3 look; // mask level, opacity, radius in pixels
layout(location = 4) out vec2 unused_corner;

void main() {
    unused_corner = vec2(0.0);
    if (drop.w <= 0.0) {
        // Far off the viewport, so that nothing is drawn even where a driver does not clip points.
        gl_Position = vec4(-1000.0, -1000.0, 0.5, 1.0);
        gl_PointSize = 1.0;
        rotation = mat3(1.0);
        look = vec3(0.0);
        return;
    }
    Sprite s = sprite(drop.xyz, drop.w);
    gl_Position = vec4(s.center * viewport_scale, s.depth, 1.0);
    gl_PointSize = max(s.diameter, 1.0);
    rotation = s.rotation;
    look = vec3(s.level, s.opacity, 0.5 * max(s.diameter, 1.0));
}
