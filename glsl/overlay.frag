#version 460
// The overlay's colours: a vertex's tint times the font atlas, both of encoded (sRGB) values.

layout(set = 0, binding = 0) uniform sampler2D atlas;

layout(location = 0) in vec2 uv;
layout(location = 1) in vec4 tint;
layout(location = 0) out vec4 color;

void main() {
    vec4 display = tint * textureLod(atlas, uv, 0.0);
    // The attachment encodes sRGB, so it is given linear colour.
    vec3 linear = mix(display.rgb / 12.92, pow((display.rgb + 0.055) / 1.055, vec3(2.4)),
                      greaterThan(display.rgb, vec3(0.04045)));
    color = vec4(linear, display.a);
}
