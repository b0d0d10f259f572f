#ifndef COMPACT_GLSL
#define COMPACT_GLSL
// The drops in view moved up, block by block, each by one subgroup: what both passes of
// src/passes/compact.rs share. A subgroup alone needs no shared memory, and its loop over a block keeps the order.
//
// The loop parts its invocations, as only some have a drop to write. Where nothing promises that they come together again
// (together.glsl), an invocation does a block alone.
#include "constants.glsl"
#include "together.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Push {
    uint chunk;  // which part of the records is bound
    uint length; // drops in it
    uint block;  // drops of a block
};

// Records of the simulation: centre in view space, radius; radius 0: nothing to draw.
layout(std430, set = 0, binding = 0) readonly buffer Drops { vec4 drops[]; };
// Drops in view of each block, chunk by chunk.
layout(std430, set = 0, binding = 1) buffer Counts { uint counts[]; };

// Number of the subgroup's block; there may be more subgroups than blocks.
uint own_block() {
    if (RECONVERGES == 0u) return gl_GlobalInvocationID.x;
    return gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID;
}

// The subgroup's invocations and this one's place among them. Not gl_SubgroupSize, which may be over 64.
uint lanes() {
    if (RECONVERGES == 0u) return 1u;
    return subgroupBallotBitCount(subgroupBallot(true));
}

uint lane() {
    if (RECONVERGES == 0u) return 0u;
    return subgroupBallotExclusiveBitCount(subgroupBallot(true));
}

// Counts the invocations whose drop is in view, and those of them before this one.
uint in_view_here(bool in_view, out uint before) {
    before = 0u;
    if (RECONVERGES == 0u) return uint(in_view);
    uvec4 here = subgroupBallot(in_view);
    before = subgroupBallotExclusiveBitCount(here);
    return subgroupBallotBitCount(here);
}
#endif
