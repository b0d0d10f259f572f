#version 460
#extension GL_GOOGLE_include_directive : require
// The paper's section 3.3, fragment half: what a pixel of a drop shows (equation 5).
#include "frame.glsl"
#include "environment.glsl"

layout(constant_id = 0) const uint IS_POINT = 1;

layout(set = 0, binding = 1) uniform sampler2DArray mask;
layout(set = 0, binding = 2) uniform sampler2D environment_map;

layout(location = 0) flat in mat3 rotation;
layout(location = 3) flat in vec3 look;
layout(location = 4) in vec2 corner;
layout(location = 0) out vec4 color;

const float WATER = 1.33;

void main() {
    vec2 at = IS_POINT != 0u ? gl_PointCoord : corner;
    vec4 transmission = textureLod(mask, vec3(at, 1.0), look.x);
    float alpha = transmission.a * look.y;
    if (alpha <= 0.0) discard;
    vec4 reflection = textureLod(mask, vec3(at, 0.0), look.x);
    vec3 reflected = rotation * normalize(reflection.xyz);
    vec3 transmitted = rotation * normalize(transmission.xyz);

    // How far the directions fan out over one pixel: the root of the product of the radial and the
    // tangential derivative. For the reflection that is 2 / R everywhere on the disc; for the
    // refraction √(dδ/db · sin δ / b) / R. Within a pixel of the rim cos θi is held at its mean.
    float pixels = look.z;
    vec2 st = 2.0 * at - 1.0;
    float b = clamp(length(st), 1e-3, 1.0), bn = b / WATER;
    float ci = sqrt(max(1.0 - b * b, min(1.0 / pixels, 1.0))), ct = sqrt(1.0 - bn * bn);
    float c = ci * ct + b * bn, s = b * ct - ci * bn;
    float fan = 2.0 * (1.0 / ci - 1.0 / (WATER * ct)) * max(2.0 * c * s, 0.0) / b;

    vec3 from_front = radiance(environment_map, reflected, 2.0 / pixels);
    vec3 through = radiance(environment_map, transmitted, sqrt(max(fan, 0.0)) / pixels);
    color = vec4(mix(through, from_front, reflection.a), alpha);
}
