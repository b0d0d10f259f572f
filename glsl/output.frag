#version 460
#extension GL_GOOGLE_include_directive : require
// The picture into an image of a host's: radiance, premultiplied, and what of a pixel it covers.
#include "frame.glsl"
#include "radiance_source.glsl"

layout(location = 0) out vec4 color;

void main() {
    vec4 pixel = pixel_at(uvec2(gl_FragCoord.xy), frame.window.z);
    color = vec4(frame.environment.y * pixel.rgb, pixel.a);
}
