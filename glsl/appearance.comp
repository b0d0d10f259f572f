#version 460
#extension GL_GOOGLE_include_directive : require
// The prefiltered picture of a far drop, from each direction in view that has none yet; one invocation a direction.
// See src/passes/appearance.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "light_model.glsl"
#include "optics.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"

layout(local_size_x = 8) in;

layout(set = 0, binding = 1) uniform sampler2D environment_map;
layout(std430, set = 0, binding = 2) buffer Pictures { uint pictures[]; };

#include "drop_light.glsl"
#include "appearance.glsl"

// Normals of the planes through the edges of what is looked at, outwards.
layout(push_constant) uniform Directions { vec4 planes[4]; };
// Sine of 8°, by how much a direction may be beyond them: light between the four nearest directions is of some that are
// 7.6° off; that nearest to a drop is 3.8° off, and a drop with a picture, at 32 radii, 2.3° beyond the edge.
const float BEYOND_EDGES = 0.14;

const uint FINEST = 16;  // texels an edge of the finest picture
const uint SAMPLES = 8;  // of a texel towards the rim
// More through a bubble: directions change without bound up to where all light is reflected, at a distance of its index.
const uint BUBBLE_SAMPLES = 16;
const float TEXEL = 2.0 / float(FINEST); // of the disc's radius
// Squared distance from the middle up to which directions change so evenly that one sample's footprint holds a texel.
const float EVEN = 0.75;

// The point (s, t) of a texel's sample, by a lattice whose columns and rows have one each: seen along the radius, where
// directions change fastest, they are at as many distances.
vec2 sample_of(uvec2 texel, uint number, uint samples) {
    vec2 place = vec2(texel) + (vec2(number, 5u * number % samples) + 0.5) / float(samples);
    return place * TEXEL - 1.0;
}

// The point (s, t) of the drop's disc, averaged over `step` in both; beyond the rim, the rim.
vec3 light(vec2 st, float step, mat3 axes) {
    float far = length(st);
    float b = min(far, 0.9999);
    vec2 radial = far > 0.0 ? st / far : vec2(1.0, 0.0);
    Intersection e = Intersection(vec3(0.0, 0.0, 1.0), vec3(radial, 0.0), b, sqrt(1.0 - b * b));
    return drop_light(environment_map, e, axes, step);
}

void main() {
    // Rows in the order of their numbers' reversed bits: a CPU's threads, which take runs of them, find as many in view.
    uint column = gl_GlobalInvocationID.x % DIRECTIONS, row = gl_GlobalInvocationID.x / DIRECTIONS;
    uint texel = (bitfieldReverse(row) >> (32 - findMSB(DIRECTIONS))) * DIRECTIONS + column;
    vec3 n = texel_direction(texel), u, v;
    bool wanted = pictures[texel] == NO_PICTURE;
    for (uint i = 0u; i < 4u; ++i) wanted = wanted && dot(n, planes[i].xyz) <= BEYOND_EDGES;
    if (!wanted) return;
    basis(n, u, v);
    mat3 axes = mat3(u, v, n);
    uint samples = WATER < 1.0 ? BUBBLE_SAMPLES : SAMPLES;

    // Along the Morton curve every coarser texel is complete when its four are: one sum a level.
    vec4 sums[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint morton = 0u; morton < FINEST * FINEST; ++morton) {
        uvec2 at = uvec2(0u);
        for (uint bit = 0u; bit < 4u; ++bit) {
            at |= (uvec2(morton >> (2u * bit), morton >> (2u * bit + 1u)) & 1u) << bit;
        }
        vec2 middle = (vec2(at) + 0.5) * TEXEL - 1.0;
        bool even = samples == SAMPLES && dot(middle, middle) < EVEN;
        // Its samples within the rim; a texel without any is filled by one at the rim, which weighs nearly nothing.
        uint within = 0u;
        for (uint number = 0u; number < samples; ++number) {
            vec2 st = sample_of(at, number, samples);
            within |= uint(dot(st, st) <= 1.0) << number;
        }
        float weight = even ? float(samples) : within == 0u ? 1e-4 : 1.0;
        float step = even ? TEXEL : TEXEL * inversesqrt(float(samples));
        vec4 sum = vec4(0.0);
        uint left = even ? 1u : max(within, 1u), edge = FINEST;
        do {
            vec2 st = even ? middle : sample_of(at, uint(findLSB(left)), samples);
            sum += weight * vec4(light(st, step, axes), 1.0);
        } while ((left &= left - 1u) != 0u);
        pictures[picture_word(texel, FINEST) + at.y * FINEST + at.x] = pack_radiance(sum.rgb / sum.a);
        for (uint level = 0u; level < 4u; ++level) {
            edge >>= 1u;
            at >>= 1u;
            sums[level] += sum;
            uint count = 4u << (2u * level);
            if (morton % count == count - 1u) {
                vec4 whole = sums[level];
                uint word = picture_word(texel, edge) + at.y * edge + at.x;
                pictures[word] = pack_radiance(whole.rgb / whole.a);
                sums[level] = vec4(0.0);
            }
        }
    }
}
