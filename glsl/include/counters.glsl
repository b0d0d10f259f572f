#ifndef COUNTERS_GLSL
#define COUNTERS_GLSL
// What a frame counts: `Counts` in src/passes/counters.rs.
layout(std430, set = 0, binding = 11) buffer Counters {
    uint large_count;
    uint camera_inside;
    uint beside_camera;
    uint lost;
    uint visible[64]; // slots that workgroups take in turn: one counter would be fought over
    uint unfit;       // drops of a host's that cannot be drawn
    uint beyond;      // those that it has no room for
} counters;
#endif
