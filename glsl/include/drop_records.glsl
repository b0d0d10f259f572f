#ifndef DROP_RECORDS_GLSL
#define DROP_RECORDS_GLSL
// A record of each drop for layers and hosts: depth, motion, number. `gather` and `large` write it, as they know where the
// drop is. See src/passes/layers.rs. Needs tile_drop.glsl.

// Where camera and drops are at the end of the motion.
layout(std140, set = 1, binding = 7) uniform Motion {
    vec4 right;         // xyz: the camera's axes then, in world space
    vec4 up;
    vec4 back;
    vec4 principal;     // xy: where the view axis meets the picture then, pixels of the whole; w: focal length then, pixels
    vec4 rain[MOST_POPULATIONS]; // xyz: how far the drops in boxes move, less the camera's motion
    vec4 classes[MOST_CLASSES];   // xyz: the same of those of each class of real rain
} motion;
// xyz: how far each placed drop moves, less the camera's motion.
layout(std430, set = 1, binding = 8) readonly buffer PlacedMoved { vec4 placed_moved[]; };
// That of a splat has its node's number, that of a large drop `large_record`: planar depth as bits; motion in pixels, two
// halves; the drop's number, low and high word.
layout(std430, set = 1, binding = 9) writeonly buffer DropRecords { uvec4 drop_records[]; };

const float FARTHEST_MOTION = 65504.0; // a half's largest

#ifdef CELLS
uvec2 number_of(uint index) {
    if (is_by_hand(index)) return uvec2(placed[by_hand_number(index)].number, 0u);
    Slab slab = slab_of(index);
    ivec3 from_camera = cell_of(slab, index / 64u - slab.first_group * CELLS_GROUP);
    // `drop_number` in src/rain/field.rs: seventeen bits of the cell's number along each axis.
    uvec3 cell = (field.classes[slab.kind].cell_low.xyz + uvec3(from_camera)) & 0x1ffffu;
    return uvec2(index % 64u + 1u | cell.x << 7 | cell.y << 24, cell.y >> 8 | cell.z << 9 | slab.kind + 1u << 26);
}

vec3 moved_by(uint index) {
    return is_by_hand(index) ? placed_moved[by_hand_number(index)].xyz : motion.classes[slab_of(index).kind].xyz;
}
#else
uvec2 number_of(uint index) {
    return uvec2(is_by_hand(index) ? placed[by_hand_number(index)].number : index + 1u, 0u);
}

vec3 moved_by(uint index) {
    return is_by_hand(index) ? placed_moved[by_hand_number(index)].xyz : motion.rain[population_number(index)].xyz;
}
#endif

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
