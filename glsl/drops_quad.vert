#version 460
#extension GL_GOOGLE_include_directive : require
// A drop too large for a point, as a quad: four vertices of a strip an instance.
#include "frame.glsl"
#include "sprite.glsl"

layout(push_constant) uniform Push { vec2 viewport_scale; };

layout(location = 0) in vec4 drop;
layout(location = 0) flat out mat3 rotation;
layout(location = 3) flat out vec3 look;
layout(location = 4) out vec2 corner; // 0 to 1, as gl_PointCoord

void main() {
    Sprite s = sprite(drop.xyz, drop.w);
    corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    vec2 place = s.center + (2.0 * corner - 1.0) * s.diameter / frame.image.xy;
    gl_Position = vec4(place * viewport_scale, s.depth, 1.0);
    rotation = s.rotation;
    look = vec3(s.level, s.opacity, 0.5 * s.diameter);
}
