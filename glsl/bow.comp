#version 460
#extension GL_GOOGLE_include_directive : require
// The light of a far drop from each bright source, by the angle between the two: the mean over its disc, which a medium of
// drops shows, with the bows that are narrower than the directions of far_glints.comp; and the two brightest images, which
// draw lines along streaks. One invocation an angle; once an environment. See src/passes/glints.rs.
#include "light_model.glsl"
#include "optics.glsl"

layout(local_size_x = 64) in;

#define SOURCES_BINDING 1
#include "glints.glsl"
#include "bow.glsl"
layout(std430, set = 0, binding = 3) writeonly buffer BowOut { FarImages bow[]; };

const uint STRIPS = 16;
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

// The image of a source of light 1 by a way; where the colours are not at one place, there where the greatest of them is.
vec4 image_by(uint way, float off, float radius) {
    vec2 brightest = vec2(0.0);
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < INDICES; ++i) {
        vec3 color = take_index(i);
        vec2 image = image_of(way, off, radius, 0.0);
        if (image.y > brightest.y) brightest = image;
        light += image.y * color;
    }
    return vec4(light, brightest.x);
}

void main() {
    uint source = gl_GlobalInvocationID.x / BOW_ANGLES, number = gl_GlobalInvocationID.x % BOW_ANGLES;
    if (source >= source_count.x) return;
    float off = HALF_TURN * float(number) / float(BOW_ANGLES - 1u), radius = sources[source].toward.w;
    // Strip by strip across the source's disc: a bow is narrower than that.
    vec3 light = vec3(0.0);
    float all = 0.0;
    for (uint strip = 0u; strip < STRIPS; ++strip) {
        float at = (float(strip) + 0.5) / float(STRIPS) * 2.0 - 1.0, share = sqrt(1.0 - at * at);
        float from = min(abs(off + at * radius), HALF_TURN), half_width = radius / float(STRIPS);
        all += share;
        for (uint ways = ways_of(from, half_width, 0.0); ways != 0u; ways &= ways - 1u) {
            for (uint i = 0u; i < INDICES; ++i) {
                vec3 color = share * take_index(i);
                light += image_of(uint(findLSB(ways)), from, half_width, 0.0).y * color;
            }
        }
    }
    vec4 first = vec4(0.0), second = first, scale = vec4(sources[source].light.rgb, 1.0);
    for (uint ways = ways_of(off, radius, 0.0); ways != 0u; ways &= ways - 1u) {
        vec4 image = image_by(uint(findLSB(ways)), off, radius);
        bool brighter = dot(image.rgb, LUMINANCE) > dot(first.rgb, LUMINANCE);
        vec4 other = brighter ? first : image;
        if (brighter) first = image;
        if (dot(other.rgb, LUMINANCE) > dot(second.rgb, LUMINANCE)) second = other;
    }
    // Over the drop's disc.
    vec4 mean = vec4(light / (all * HALF_TURN), 0.0);
    bow[gl_GlobalInvocationID.x] = FarImages(mean * scale, first * scale, second * scale);
}
