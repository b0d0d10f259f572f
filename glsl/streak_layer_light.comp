#version 460
#extension GL_GOOGLE_include_directive : require
// What the streaks of the streak layer show at the middle of each tile, the mean light of a far drop, and that of the first line
// that the brightest source draws along them; one invocation a tile, when the view turns. See src/passes/composite.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "divided.glsl"
#include "tile_buffers.glsl"
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "splat_table.glsl"
#include "far_light.glsl"
#include "far_glints.glsl"
#include "streak_layer_lines.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 1, binding = 6) writeonly buffer StreakLayerLight { uvec4 streak_layer_light[]; };

void main() {
    uint tile = group_number() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uvec2 at = first_tile() + divided(tile, tiles_across()).yx;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec2 middle = (vec2(at) + 0.5) * vec2(TILE);
    vec3 c = far_light(world * normalize(ray_through(middle)), true);
    uint of_line = GLINTS != 0u ? lines_at(middle).light : 0u;
    streak_layer_light[tile] = uvec4(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 0.0)), of_line, 0u);
}
