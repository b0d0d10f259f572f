// What flat_rays.comp and flat_light.comp share. Binding 2.
#include "constants.glsl"

// Shapes (shape.glsl) of drops that block as much as each other.
layout(std430, set = 0, binding = 2) readonly buffer FlatRain {
    vec4 flat_shapes[FLAT_SHAPES];
    float flat_round_share; // of what the rain blocks, by spheres
};

// A sum stands for the light of so large a part of one: all rays in one direction are less than 2^32.
const float SUM_OF_ONE = 16384.0;

// Along parallel rays each half's outline is half an ellipse, of this height.
float half_height(vec4 shape, bool upper, vec3 d) {
    return length(vec2((upper ? shape.y : shape.z) * length(d.xz), shape.x * d.y));
}
