// What a frame counts: `Counts` in src/passes/counters.rs. Define COUNTERS_BINDING before.
layout(std430, set = 0, binding = COUNTERS_BINDING) buffer Counters {
    uint large_count;
    uint camera_inside;
    uint beside_camera;
    uint lost;
    uint visible[64]; // slots that workgroups take in turn: one counter would be fought over
} counters;
