#version 460
#extension GL_GOOGLE_include_directive : require
// The brightest images of the bright sources in a far drop, seen from every direction; one invocation a
// direction, once an environment. See src/passes/glints.rs.
#include "light_model.glsl"
#include "optics.glsl"
#include "octahedron.glsl"

layout(local_size_x = 8) in;

#define SOURCES_BINDING 1
#include "glints.glsl"
#include "far_glints.glsl"
layout(std430, set = 0, binding = 2) writeonly buffer FarGlintsOut { FarGlints far_glints[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709
// Half the angle of a direction's texel: over so much an image's light is the mean, so that it does not depend on
// where in its texel a direction lies.
const float HALF_TEXEL = 0.022;

void main() {
    uint texel = gl_GlobalInvocationID.x;
    if (texel >= DIRECTIONS * DIRECTIONS) return;
    vec3 axis = texel_direction(texel);
    vec3 first_at = vec3(0.0), second_at = first_at, first = first_at, second = first_at, others = first_at;
    for (uint i = 0u; i < source_count.x; ++i) {
        vec3 toward = sources[i].toward.xyz, aside = aside_of(axis, toward);
        float off = angle_between(axis, toward), radius = max(sources[i].toward.w, HALF_TEXEL);
        for (uint ways = ways_of(off, radius, 0.0); ways != 0u; ways &= ways - 1u) {
            uint way = uint(findLSB(ways));
            // Where the colours are not at one place, the greatest of them is.
            vec2 image = vec2(0.0);
            vec3 light = vec3(0.0);
            for (uint j = 0u; j < INDICES; ++j) {
                vec3 color = take_index(j);
                vec2 of_color = image_of(way, off, radius, 0.0);
                if (of_color.y > image.y) image = of_color;
                light += of_color.y * color * sources[i].light.rgb;
            }
            vec3 at = image.x * aside;
            if (dot(light, LUMINANCE) > dot(first, LUMINANCE)) {
                vec3 was_at = first_at, was = first;
                first_at = at;
                first = light;
                at = was_at;
                light = was;
            }
            if (dot(light, LUMINANCE) > dot(second, LUMINANCE)) {
                vec3 was = second;
                second_at = at;
                second = light;
                light = was;
            }
            others += light;
        }
    }
    far_glints[texel] = FarGlints(vec4(first_at, others.r), vec4(first, others.g),
                                  vec4(second_at, others.b), vec4(second, 0.0));
}
