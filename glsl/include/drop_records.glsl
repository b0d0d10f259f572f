#ifndef DROP_RECORDS_GLSL
#define DROP_RECORDS_GLSL
// A record of each drop for layers and hosts: depth, motion, number. `gather` and `large` write it, as they know where the
// drop is. See src/passes/layers.rs.
#include "tile_drop.glsl"

// Where camera and drops are at the end of the motion. The last uniform buffer of a pipeline: lavapipe of Mesa 22.3 crashes where
// a branch depends on nothing but the fourth one, and none depends on this.
layout(std140, set = 1, binding = 24) uniform Motion {
    vec4 right;         // xyz: the camera's axes then, in world space
    vec4 up;
    vec4 back;
    vec4 principal;     // xy: where the view axis meets the picture then, pixels of the whole; w: focal length then, pixels
    vec4 random[MOST_CLASSES]; // xyz: how far drops of each population move, or of each class of real rain, less the camera's motion
} motion;
// xyz: how far each placed drop moves, less the camera's motion.
layout(std430, set = 1, binding = 8) readonly buffer PlacedMoved { vec4 placed_moved[]; };
// A splat's record has its node's number, a large drop's `large_record`. It holds planar depth as bits; motion in pixels, two
// halves; the drop's number, low and high word.
layout(std430, set = 1, binding = 9) writeonly buffer DropRecords { uvec4 drop_records[]; };

const float FARTHEST_MOTION = 65504.0; // a half's largest

uvec2 number_of(uint index) {
    if (is_by_hand(index)) return uvec2(placed_at(by_hand_number(index)).number, 0u);
    return random_number(index);
}

vec3 moved_by(uint index) {
    return is_by_hand(index) ? placed_moved[by_hand_number(index)].xyz : motion.random[kind_of(index)].xyz;
}

uvec4 record_of(uint index, Drop drop) {
    vec3 now = drop.view, from = drop.relative + moved_by(index);
    vec3 then = vec3(dot(motion.right.xyz, from), dot(motion.up.xyz, from), dot(motion.back.xyz, from));
    vec2 here = frame.principal.xy + vec2(now.x, -now.y) * (frame.image.z / -now.z);
    vec2 there = motion.principal.xy + vec2(then.x, -then.y) * (motion.principal.w / -then.z);
    // A drop whose centre is beside or behind the camera has no place in the picture.
    vec2 moves = now.z < 0.0 && then.z < 0.0 ? clamp(there - here, -FARTHEST_MOTION, FARTHEST_MOTION) : vec2(0.0);
    return uvec4(floatBitsToUint(-now.z), packHalf2x16(moves), number_of(index));
}
#endif
