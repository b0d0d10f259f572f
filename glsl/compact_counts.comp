#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// How many drops of each block are in view. See src/passes/compact.rs.
#include "compact.glsl"

void main() {
    uint number = own_block();
    if (number >= BLOCKS) return;
    uint first = min(number * block, length), end = min(first + block, length);
    uint lanes = lanes(), lane = lane(), count = 0u;
    for (uint base = first; base < end; base += lanes) {
        uint at = base + lane;
        bool in_view = at < end && drops[min(at, end - 1u)].w > 0.0;
        count += subgroupBallotBitCount(subgroupBallot(in_view));
    }
    if (lane == 0u) counts[chunk * BLOCKS + number] = count;
}
