#version 460
#extension GL_GOOGLE_include_directive : require
// The environment behind the drops of tiles, CELLS: through far rain; one invocation a pixel. See
// src/passes/composite.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "environment.glsl"
#include "tile_buffers.glsl"
#ifdef CELLS
#define SOURCES_BINDING 17
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "rain_field.glsl"

#include "sources.glsl"
#include "bow.glsl"
layout(std430, set = 0, binding = 19) readonly buffer Bow { vec4 bow[]; };
#include "medium.glsl"
#endif

layout(local_size_x = 16, local_size_y = 4) in;

layout(set = 0, binding = 18) uniform sampler2D environment_map;
layout(std430, set = 0, binding = 12) writeonly buffer Sky { uvec2 sky[]; };

// Samples along an edge of a pixel: a third of a texel apart, so that their mean is that of the pixel's square and
// not of a blurred neighbourhood; four at most, between which the levels do the rest. Powers of two, so that
// equal radiances keep their last bit. src/plan/background.rs tells the error of the same.
uint samples_along(float focal) {
    float thirds = 3.0 / (focal * frame.environment.x);
    return thirds <= 1.0 ? 1u : thirds <= 2.0 ? 2u : 4u;
}

void main() {
    uvec2 place = gl_GlobalInvocationID.xy, in_tile = place % TILE;
    uint tile = place.y / TILE.y * tiles_across() + place.x / TILE.x;
    if (place.x >= tiles_across() * TILE.x || tile >= TILE_COUNT) return;
    float focal = frame.image.z;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    uint edge = samples_along(focal);
    float share = 1.0 / float(edge);
    vec3 c = vec3(0.0);
    for (uint i = 0u; i < edge * edge; ++i) {
        vec3 ray = ray_through(vec2(place + first_tile() * TILE) + share * (vec2(i % edge, i / edge) + 0.5));
        float far = length(ray);
        vec3 behind = radiance(environment_map, world * ray / far, share * sqrt(focal / far) / far);
#ifdef CELLS
        if (field.medium.w > 0.0) behind = through_medium(behind, ray / far, world * ray / far, field.medium.z);
#endif
        c += behind;
    }
    c *= share * share;
    sky[tile * PIXELS + in_tile.y * TILE.x + in_tile.x] = uvec2(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 0.0)));
}
