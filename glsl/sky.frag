#version 460
#extension GL_GOOGLE_include_directive : require
// The environment behind the drops, seen straight.
#include "frame.glsl"
#include "projection.glsl"
#include "environment.glsl"

layout(set = 0, binding = 1) uniform sampler2D environment_map;
layout(location = 0) out vec4 color;

void main() {
    vec2 offset = plane_of(gl_FragCoord.xy + vec2(frame.window.xy));
    vec3 ray = offset.x * frame.right.xyz - offset.y * frame.up.xyz - frame.image.z * frame.back.xyz;
    // A pixel's angle: cos³ of the angle from the axis less in solid angle than at the middle.
    float far = length(ray), focal = frame.image.z;
    float spread = sqrt(focal / far) / far;
    color = vec4(radiance(environment_map, ray / far, spread), 1.0);
}
