#version 460
#extension GL_GOOGLE_include_directive : require
// The global photographic operator (Reinhard et al. 2002): L = key / L̄ Lw, or a fixed factor
// times Lw; Ld = L / (1 + L).
#include "frame.glsl"
#include "radiance_source.glsl"

layout(constant_id = 1) const uint PHOTOGRAPHIC = 1;

layout(location = 0) flat in float exposure;
layout(location = 1) flat in uint width; // a CPU driver would read the constant once a pixel
layout(location = 0) out vec4 color;

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

void main() {
    vec3 radiance = exposure * pixel_at(uvec2(gl_FragCoord.xy), width).rgb;
    // One quotient, not three.
    if (PHOTOGRAPHIC != 0u) radiance *= 1.0 / (1.0 + dot(radiance, LUMINANCE));
    color = vec4(radiance, 1.0); // the attachment encodes sRGB
}
