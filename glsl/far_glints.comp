#version 460
#extension GL_GOOGLE_include_directive : require
// The brightest images of the bright sources in a far drop, by the angle between source and drop; one invocation an angle
// and source, once an environment. See src/passes/glints.rs.
#include "light_model.glsl"
#include "optics.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(local_size_x = 8) in;

#include "glints.glsl"
#include "far_glints.glsl"
layout(std430, set = 0, binding = 2) writeonly buffer FarGlintsOut { uvec4 far_glints[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709
// Half the widest step from angle to angle: an image's light is the mean over so much at least.
const float HALF_STEP = 1.0 / float(HALF_ANGLES);

void main() {
    uint source = gl_GlobalInvocationID.x / GLINT_ANGLES, number = gl_GlobalInvocationID.x % GLINT_ANGLES;
    if (source >= source_count.x) return;
    float off = angle_numbered(number), radius = max(sources[source].toward.w, HALF_STEP);
    // xyz: light, w: impact parameter.
    vec4 first = vec4(0.0), second = first;
    vec3 others = vec3(0.0);
    for (uint ways = ways_of(off, radius, 0.0); ways != 0u; ways &= ways - 1u) {
        // Where the colours are not at one place, the greatest of them is.
        vec2 image = vec2(0.0);
        vec4 light = vec4(0.0);
        for (uint j = 0u; j < INDICES; ++j) {
            vec3 color = take_index(j);
            vec2 of_color = image_of(uint(findLSB(ways)), off, radius, 0.0);
            if (of_color.y > image.y) image = of_color;
            light.rgb += of_color.y * color * sources[source].light.rgb;
        }
        light.w = image.x;
        if (dot(light.rgb, LUMINANCE) > dot(first.rgb, LUMINANCE)) {
            vec4 was = first;
            first = light;
            light = was;
        }
        if (dot(light.rgb, LUMINANCE) > dot(second.rgb, LUMINANCE)) {
            vec4 was = second;
            second = light;
            light = was;
        }
        others += light.rgb;
    }
    far_glints[gl_GlobalInvocationID.x] = uvec4(packHalf2x16(vec2(first.w, second.w) / sin(off)),
                                                pack_radiance(first.rgb), pack_radiance(second.rgb), pack_radiance(others));
}
