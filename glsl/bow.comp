#version 460
#extension GL_GOOGLE_include_directive : require
// The mean light of a far drop from each bright source, by the angle between the two: what a medium of drops shows, with
// the bows that are narrower than the directions of far_glints.comp. One invocation an angle; once an environment. See
// src/passes/glints.rs.
#include "light_model.glsl"
#include "optics.glsl"

layout(local_size_x = 64) in;

#include "glints.glsl"
#include "constants.glsl"
layout(std430, set = 0, binding = 3) writeonly buffer BowOut { vec4 bow[]; };

const uint STRIPS = 16;

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
    // Over the drop's disc.
    bow[gl_GlobalInvocationID.x] = vec4(light / (all * HALF_TURN) * sources[source].light.rgb, 0.0);
}
