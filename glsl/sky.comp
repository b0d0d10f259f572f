#version 460
#extension GL_GOOGLE_include_directive : require
// The environment behind the drops of tiles; one invocation a pixel. See
// src/passes/composite.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

layout(set = 0, binding = 10) uniform sampler2D environment_map;
layout(std430, set = 0, binding = 12) writeonly buffer Sky { uvec2 sky[]; };

void main() {
    uvec2 place = gl_GlobalInvocationID.xy, in_tile = place % TILE;
    uint tile = place.y / TILE.y * tiles_across() + place.x / TILE.x;
    if (place.x >= tiles_across() * TILE.x || tile >= TILE_COUNT) return;
    vec2 offset = vec2(place) + 0.5 - 0.5 * frame.image.xy;
    float focal = frame.image.z;
    vec3 ray = vec3(offset.x, -offset.y, -focal);
    float far = length(ray);
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec3 c = radiance(environment_map, world * ray / far, sqrt(focal / far) / far);
    sky[tile * PIXELS + in_tile.y * TILE.x + in_tile.x] = uvec2(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 0.0)));
}
