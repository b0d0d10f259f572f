#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// The records of the drops in view one after the other, in the order of their index, and the arguments of their
// draw. See src/passes/compact.rs.
#include "compact.glsl"

layout(constant_id = 0) const uint QUADS = 0; // 1: an instance a drop, else a vertex

layout(std430, set = 0, binding = 2) writeonly buffer Compacted { vec4 compacted[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Arguments { uvec4 arguments[]; };

void main() {
    uint number = own_block();
    if (number >= BLOCKS) return;
    uint first = min(number * block, length), end = min(first + block, length);
    uint lanes = lanes(), lane = lane(), before = 0u;
    // All invocations take as many turns, so that they stay together.
    for (uint base = 0u; base < number; base += lanes) {
        uint at = base + lane;
        before += counts[chunk * BLOCKS + min(at, number - 1u)] * uint(at < number);
    }
    uint place = RECONVERGES != 0u ? subgroupAdd(before) : before;
    for (uint base = first; base < end; base += lanes) {
        uint at = base + lane;
        vec4 drop = drops[min(at, end - 1u)];
        bool in_view = drop.w * float(at < end) > 0.0;
        uint ahead, here = in_view_here(in_view, ahead);
        if (in_view) compacted[place + ahead] = drop;
        place += here;
    }
    if (number == BLOCKS - 1u && lane == 0u) {
        arguments[chunk] = QUADS != 0u ? uvec4(4u, place, 0u, 0u) : uvec4(place, 1u, 0u, 0u);
    }
}
