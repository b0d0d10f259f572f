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
    for (uint at = lane; at < number; at += lanes) before += counts[chunk * BLOCKS + at];
    uint place = subgroupAdd(before);
    for (uint base = first; base < end; base += lanes) {
        uint at = base + lane;
        vec4 drop = drops[min(at, end - 1u)];
        bool in_view = at < end && drop.w > 0.0;
        uvec4 here = subgroupBallot(in_view);
        if (in_view) compacted[place + subgroupBallotExclusiveBitCount(here)] = drop;
        place += subgroupBallotBitCount(here);
    }
    if (number == BLOCKS - 1u && lane == 0u) {
        arguments[chunk] = QUADS != 0u ? uvec4(4u, place, 0u, 0u) : uvec4(place, 1u, 0u, 0u);
    }
}
