#version 460
// Puts the drops too large for a point into back-to-front order and writes the draw's arguments.
// Rank by counting: n reads a drop, against over 65,000 fragments that each such drop draws.

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint MAX_LARGE = 1; // 0 is simulate.comp's

layout(std430, set = 0, binding = 0) readonly buffer LargeDrops { vec4 large[]; };
layout(std430, set = 0, binding = 1) readonly buffer LargeIndex { uint large_index[]; };
layout(std430, set = 0, binding = 2) readonly buffer Counters { uint large_count; };
layout(std430, set = 0, binding = 3) writeonly buffer Ordered { vec4 ordered[]; };
layout(std430, set = 0, binding = 4) writeonly buffer Arguments { uint arguments[4]; };

// Is drop `a` to be drawn before `b`? Farther first; the index decides between equals, so that the picture is the
// same on every run.
bool before(uint a, uint b) {
    float da = dot(large[a].xyz, large[a].xyz), db = dot(large[b].xyz, large[b].xyz);
    return da > db || (da == db && large_index[a] > large_index[b]);
}

void main() {
    uint count = min(large_count, MAX_LARGE);
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint i = gl_GlobalInvocationID.x; i < count; i += stride) {
        uint rank = 0u;
        for (uint j = 0u; j < count; ++j) rank += uint(before(j, i));
        ordered[rank] = large[i];
    }
    if (gl_GlobalInvocationID.x == 0u) arguments = uint[4](4u, count, 0u, 0u);
}
