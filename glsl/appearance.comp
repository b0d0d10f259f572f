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

// The disc has 16 x 16 cells of so many samples, also where the finest picture is 32 x 32: towards the rim a texel takes those of its
// cell that lie within it.
const uint GRID = 16, WATER_SAMPLES = 8;
// More through a bubble: directions change without bound up to where all light is reflected, at a distance of its index.
const uint BUBBLE_SAMPLES = 16;
const uint FINER = PICTURE_LEVEL == 5u ? 2u : 1u; // texels an edge of a cell
const uint FINEST = GRID * FINER, LEVELS = PICTURE_LEVEL == 5u ? 5u : 4u;
// Squared distance from the middle up to which directions change so calmly that one sample's footprint holds a texel.
const float CALM2 = 0.75;

// Where a cell's sample is, in cells, by a lattice whose columns and rows have one each: seen along the radius, where
// directions change fastest, they are at as many distances.
vec2 sample_of(uvec2 cell, uint number, uint samples) {
    return vec2(cell) + (vec2(number, 5u * number % samples) + 0.5) / float(samples);
}

// The point (s, t) of the disc at a place in cells.
vec2 on_disc(vec2 place) {
    return place * (2.0 / float(GRID)) - 1.0;
}

// Which of its cell's samples are a texel's own, and within the rim. (A constant number of turns, which compilers write out: a CPU
// driver ends all loops of an invocation after 65,535, and those of a bubble's light take 40,000.)
uint samples_within(uvec2 texel, uint samples) {
    uint within = 0u;
    for (uint number = 0u; number < BUBBLE_SAMPLES; ++number) {
        vec2 place = sample_of(texel / FINER, number, samples), st = on_disc(place);
        bool is_own = number < samples && uvec2(place * float(FINER)) == texel;
        within |= uint(is_own && dot(st, st) <= 1.0) << number;
    }
    return within;
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
    // Rows in the order of their numbers' reversed bits: threads of a CPU, which take runs of rows, find about equally many in view.
    uint column = gl_GlobalInvocationID.x % DIRECTIONS, row = gl_GlobalInvocationID.x / DIRECTIONS;
    uint texel = (bitfieldReverse(row) >> (32 - findMSB(DIRECTIONS))) * DIRECTIONS + column;
    vec3 n = texel_direction(texel), u, v;
    bool wanted = pictures[texel] == NO_PICTURE;
    for (uint i = 0u; i < 4u; ++i) wanted = wanted && dot(n, planes[i].xyz) <= BEYOND_EDGES;
    if (!wanted) return;
    basis(n, u, v);
    mat3 axes = mat3(u, v, n);
    uint samples = WATER < 1.0 ? BUBBLE_SAMPLES : WATER_SAMPLES, of_texel = samples / (FINER * FINER);

    float size = 2.0 / float(FINEST); // of a texel, in radii
    // Along the Morton curve every coarser texel is complete when its four are: one sum a level.
    vec4 sums[5] = vec4[5](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint morton = 0u; morton < FINEST * FINEST; ++morton) {
        uvec2 at = uvec2(0u);
        for (uint bit = 0u; bit < LEVELS; ++bit) {
            at |= (uvec2(morton >> (2u * bit), morton >> (2u * bit + 1u)) & 1u) << bit;
        }
        vec2 middle = (vec2(at) + 0.5) * size - 1.0;
        bool calm = samples == WATER_SAMPLES && dot(middle, middle) < CALM2;
        // A texel without any is filled by one at the rim, which weighs nearly nothing.
        uint within = samples_within(at, samples);
        bool by_middle = calm || within == 0u;
        float weight = calm ? float(of_texel) : within == 0u ? 1e-4 : 1.0;
        float step = calm ? size : size * inversesqrt(float(of_texel));
        vec4 sum = vec4(0.0);
        uint left = by_middle ? 1u : within, edge = FINEST;
        do {
            vec2 st = by_middle ? middle : on_disc(sample_of(at / FINER, uint(findLSB(left)), samples));
            sum += weight * vec4(light(st, step, axes), 1.0);
        } while ((left &= left - 1u) != 0u);
        pictures[picture_word(texel, FINEST) + at.y * FINEST + at.x] = pack_radiance(sum.rgb / sum.a);
        for (uint level = 0u; level < LEVELS; ++level) {
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
