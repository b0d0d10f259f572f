#version 460
// Finished pictures in a window: one, or two models side by side and their difference.

layout(set = 0, binding = 0) uniform sampler2D first;
layout(set = 0, binding = 1) uniform sampler2D second;

layout(push_constant) uniform Push { vec2 size; }; // of the window, in pixels

layout(constant_id = 0) const uint PANES = 1; // or 3: first, second, difference
layout(constant_id = 1) const uint GAIN = 1;  // of the difference

layout(location = 0) out vec4 color;

const float LINE_PX = 2.0; // between panes

vec3 encode(vec3 linear) { // sRGB, IEC 61966-2-1
    return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, greaterThan(linear, vec3(0.0031308)));
}

vec3 decode(vec3 display) {
    return mix(display / 12.92, pow((display + 0.055) / 1.055, vec3(2.4)), greaterThan(display, vec3(0.04045)));
}

void main() {
    vec2 place = gl_FragCoord.xy / size;
    if (PANES == 1u) {
        color = texelFetch(first, ivec2(place * vec2(textureSize(first, 0))), 0);
        return;
    }
    place.x *= float(PANES);
    float pane = min(floor(place.x), float(PANES) - 1.0);
    place.x -= pane;
    ivec2 at = ivec2(place * vec2(textureSize(first, 0)));
    vec3 a = texelFetch(first, at, 0).rgb;
    vec3 b = texelFetch(second, at, 0).rgb;
    // The difference as the eye sees it: between display values.
    vec3 difference = decode(min(float(GAIN) * abs(encode(a) - encode(b)), 1.0));
    color = vec4(pane == 0.0 ? a : pane == 1.0 ? b : difference, 1.0);
    if (pane > 0.0 && place.x * size.x / float(PANES) < LINE_PX) color.rgb = vec3(0.0);
}
