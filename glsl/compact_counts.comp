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
        // No branch, which might part the invocations.
        float radius = drops[min(at, end - 1u)].w * float(at < end);
        uint before;
        count += in_view_here(radius > 0.0, before);
    }
    if (lane == 0u) counts[chunk * BLOCKS + number] = count;
}
