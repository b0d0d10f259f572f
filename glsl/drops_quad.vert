#version 460
#extension GL_GOOGLE_include_directive : require
// A drop as a quad, four vertices of a strip an instance: those too large for a point, or all.
#include "frame.glsl"
#include "sprite.glsl"

layout(push_constant) uniform Push { vec2 viewport_scale; };

layout(location = 0) in vec4 drop;
layout(location = 0) flat out mat3 rotation;
layout(location = 3) flat out vec3 look;
layout(location = 4) out vec2 corner; // 0 to 1, as gl_PointCoord

void main() {
    if (drop.w <= 0.0) {
        // Nothing to draw: a quad without area.
        gl_Position = vec4(-1000.0, -1000.0, 0.5, 1.0);
        rotation = mat3(1.0);
        look = vec3(0.0);
        corner = vec2(0.0);
        return;
    }
    Sprite s = sprite(drop.xyz, drop.w);
    corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    float diameter = max(s.diameter, 1.0); // a smaller one would miss the pixels' middles
    vec2 place = s.center + (2.0 * corner - 1.0) * diameter / vec2(frame.window.zw);
    gl_Position = vec4(place * viewport_scale, s.depth, 1.0);
    rotation = s.rotation;
    look = vec3(s.level, s.opacity, 0.5 * diameter);
}
