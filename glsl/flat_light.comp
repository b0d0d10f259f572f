#version 460
#extension GL_GOOGLE_include_directive : require
// The mean light of far drops that are flattened, from each direction in view that has none yet: a word for each of a few
// diameters, and another for the lower half of their outline. One invocation a direction. See src/passes/flat_light.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "light_model.glsl"
#include "optics.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "drop_light.glsl"
#include "shape_light.glsl"

layout(local_size_x = 8) in;

layout(set = 0, binding = 1) uniform sampler2D environment_map;
layout(std430, set = 0, binding = 2) buffer FlatLight { uvec4 flat_light[]; };

// What is looked at, as in appearance.comp; and the shapes (shape.glsl) of the diameters.
layout(push_constant) uniform FlatLightPush {
    vec4 planes[4];
    vec4 shapes[4];
};
// Sine of 8°: see appearance.comp.
const float BEYOND_EDGES = 0.14;

// Rays of a direction and diameter, spread over the outline by Vogel's spiral: each is in a ring of its own. Towards the rim, where
// directions change fastest, rings are smaller: if a share x of the rays is outside a ring, x² of the outline's area is.
const uint RAYS = 96;

// Mean light of a shape seen along `d`, over its outline, of which each half is half an ellipse for parallel rays; `of_lower`: over
// the lower half.
vec3 mean_light(vec4 shape, vec3 d, vec3 right, vec3 upwards, out vec3 of_lower) {
    float level = length(d.xz);
    vec2 high = sqrt(shape.yz * shape.yz * level * level + shape.x * shape.x * d.y * d.y); // of the halves' outlines
    float step = sqrt(PI * shape.x * 0.5 * (high.x + high.y) / float(RAYS));
    vec4 sum = vec4(0.0), lower = vec4(0.0);
    for (uint i = 0u; i < RAYS; ++i) {
        float left = 1.0 - (float(i) + 0.5) / float(RAYS), far = sqrt(1.0 - left * left);
        float turn = 2.39996323 * float(i), up = sin(turn);
        float half_high = up > 0.0 ? high.x : high.y;
        vec3 to_ray = far * (shape.x * cos(turn) * right + half_high * up * upwards) + vec3(0.0, shape.w, 0.0);
        vec3 light = shape_light_by_index(false, environment_map, environment_map, shape, to_ray, d, step * sqrt(2.0 * left));
        vec4 part = half_high * left * vec4(light, 1.0);
        sum += part;
        if (up <= 0.0) lower += part;
    }
    of_lower = lower.rgb / lower.a;
    return sum.rgb / sum.a;
}

void main() {
    // appearance.comp says why rows are taken in this order.
    uint column = gl_GlobalInvocationID.x % DIRECTIONS, row = gl_GlobalInvocationID.x / DIRECTIONS;
    uint texel = (bitfieldReverse(row) >> (32 - findMSB(DIRECTIONS))) * DIRECTIONS + column;
    vec3 d = texel_direction(texel);
    bool wanted = flat_light[2u * texel].x == NO_PICTURE;
    for (uint i = 0u; i < 4u; ++i) wanted = wanted && dot(d, planes[i].xyz) <= BEYOND_EDGES;
    if (!wanted) return;
    vec3 right = dot(d.xz, d.xz) > 1e-12 ? normalize(vec3(-d.z, 0.0, d.x)) : vec3(1.0, 0.0, 0.0);
    vec3 upwards = cross(right, d);
    uvec4 words, of_lower;
    for (uint i = 0u; i < 4u; ++i) {
        vec3 lower;
        words[i] = pack_radiance(mean_light(shapes[i], d, right, upwards, lower));
        of_lower[i] = pack_radiance(lower);
    }
    flat_light[2u * texel] = words;
    flat_light[2u * texel + 1u] = of_lower;
}
