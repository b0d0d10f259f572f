#version 460
#extension GL_GOOGLE_include_directive : require
// The paper's section 3.2: one level of the mask. Layer 0: reflected direction and reflectance;
// layer 1: twice-refracted direction and coverage. See src/passes/mask.rs.
#include "optics.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform writeonly image2DArray level_image;
layout(push_constant) uniform Push {
    float half_angle;
};

// Subsamples of a rim texel, stratified 8 x 4 with a fixed jitter: 32 as in the paper, but two
// orders of magnitude less noise than 32 random ones.
const ivec2 STRATA = ivec2(8, 4);

uint hash(uint x) {
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
    return (x >> 22u) ^ x;
}

float coverage(vec2 st, float texel) {
    float far = length(st), reach = texel * 0.70710678;
    if (far + reach <= 1.0) return 1.0;
    if (far - reach >= 1.0) return 0.0;
    uint inside = 0u;
    for (int y = 0; y < STRATA.y; ++y) {
        for (int x = 0; x < STRATA.x; ++x) {
            uint seed = hash(uint(y * STRATA.x + x) ^ hash(gl_GlobalInvocationID.x
                             ^ (gl_GlobalInvocationID.y << 16)));
            vec2 jitter = vec2(seed & 0xffffu, seed >> 16) / 65536.0;
            vec2 place = (vec2(x, y) + jitter) / vec2(STRATA) - 0.5;
            inside += uint(length(st + place * texel) <= 1.0);
        }
    }
    return float(inside) / float(STRATA.x * STRATA.y);
}

void main() {
    ivec2 size = imageSize(level_image).xy, at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, size))) return;
    float texel = 2.0 / float(size.x);
    vec2 st = (vec2(at) + 0.5) * texel - 1.0;
    st.y = -st.y; // rows go down, t goes up
    Encounter e = mask_encounter(st, half_angle);
    imageStore(level_image, ivec3(at, 0), vec4(reflected(e), reflectance(e)));
    imageStore(level_image, ivec3(at, 1), vec4(transmitted(e), coverage(st, texel)));
}
