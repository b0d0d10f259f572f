#version 460
#extension GL_GOOGLE_include_directive : require
// The paper's section 3.2: one level of the mask. Layer 0: reflected direction and reflectance;
// layer 1: twice-refracted direction and coverage. See src/passes/mask.rs.
#include "light_model.glsl"
#include "optics.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform writeonly image2DArray level_image;
layout(push_constant) uniform Push {
    float sin_a; // of the level's half-angle
    float cos_a;
};

// Columns that a rim texel is cut into: as many as the paper takes random subsamples, but in each
// the covered height is exact. Largest error of a texel 0.01 (32 stratified points: 0.13).
const int COLUMNS = 32;

float coverage(vec2 st, float texel) {
    float far = length(st), reach = texel * 0.70710678;
    if (far + reach <= 1.0) return 1.0;
    if (far - reach >= 1.0) return 0.0;
    float low = st.y - 0.5 * texel, high = st.y + 0.5 * texel, covered = 0.0;
    for (int column = 0; column < COLUMNS; ++column) {
        float s = st.x + ((float(column) + 0.5) / float(COLUMNS) - 0.5) * texel;
        float rim = sqrt(max((1.0 - s) * (1.0 + s), 0.0));
        covered += max(min(high, rim) - max(low, -rim), 0.0);
    }
    return covered / (float(COLUMNS) * texel);
}

void main() {
    ivec2 size = imageSize(level_image).xy, at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, size))) return;
    float texel = 2.0 / float(size.x);
    vec2 st = (vec2(at) + 0.5) * texel - 1.0;
    st.y = -st.y; // rows go down, t goes up
    Intersection e = mask_intersection(st, sin_a, cos_a);
    imageStore(level_image, ivec3(at, 0), vec4(reflected(e), reflectance(e)));
    imageStore(level_image, ivec3(at, 1), vec4(transmitted(e), coverage(st, texel)));
}
