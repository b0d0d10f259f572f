#version 460
#extension GL_GOOGLE_include_directive : require
// Where every drop is and whether it is in view; one invocation a drop. See src/passes/simulate.rs.
#include "frame.glsl"
#include "rain.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint STORED = 0; // 1: the paper's stored positions
layout(constant_id = 1) const uint MAX_LARGE = 1;

layout(push_constant) uniform Push {
    uint first;  // index of the first drop of this chunk
    uint length; // number of drops in this chunk
};

// Drops as the draw reads them: centre in view space, radius; radius 0: nothing to draw.
layout(std430, set = 0, binding = 1) writeonly buffer Drops { vec4 drops[]; };
layout(std430, set = 0, binding = 2) readonly buffer PlacedDrops { Placed placed[]; };
// Positions of the paper's model, in the rain box; unused otherwise.
layout(std430, set = 0, binding = 3) buffer Stored { vec4 stored[]; };
// Drops too large for a point, unordered.
layout(std430, set = 0, binding = 4) writeonly buffer LargeDrops { vec4 large[]; };
layout(std430, set = 0, binding = 5) writeonly buffer LargeIndex { uint large_index[]; };
#include "counters.glsl"

vec3 wrap(vec3 p) {
    vec3 box = frame.extent.xyz;
    return p - 2.0 * box * floor((p + box) / (2.0 * box));
}

vec3 relative_stored(uint index, uint slot) {
    vec3 p;
    if (frame.seed.z != 0u) {
        p = vec3(ivec3(start(population_numbered(0u), index) + frame.shift.xyz)) * frame.units.xyz;
    } else {
        p = wrap(stored[slot].xyz + frame.motion.xyz);
    }
    stored[slot] = vec4(p, 0.0);
    return wrap(p - frame.camera_high.xyz);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= length) return;
    uint index = first + slot;

    vec3 p;
    float radius;
    if (index < frame.camera_place.w) {
        vec4 drop = drop_at(population_numbered(population_number(index)), index);
        p = STORED != 0u ? relative_stored(index, slot) : drop.xyz;
        radius = drop.w;
    } else {
        Placed drop = placed[index - frame.camera_place.w];
        p = relative_placed(drop);
        radius = drop.high.w;
    }

    vec3 v = view_space(p);
    float distance2;
    uint what = visibility(v, radius, distance2);
    if (what == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
    if (what == BESIDE_CAMERA) atomicAdd(counters.beside_camera, 1u);
    bool visible = what == VISIBLE;

    if (visible) {
        atomicAdd(counters.visible[gl_WorkGroupID.x & 63u], 1u);
        // Point sizes over the limit are silently clamped by drivers: those drops become quads.
        float radius2 = radius * radius, flat2 = v.z * v.z - radius2;
        float diameter = 2.0 * frame.image.z * radius * sqrt(sqrt(distance2 - radius2))
                         / (sqrt(sqrt(flat2)) * sqrt(flat2));
        if (!(diameter <= frame.image.w)) {
            uint at = atomicAdd(counters.large_count, 1u);
            if (at < MAX_LARGE) {
                large[at] = vec4(v, radius);
                large_index[at] = index;
            } else {
                atomicAdd(counters.lost, 1u);
            }
            visible = false;
        }
    }
    drops[slot] = vec4(v, visible ? radius : 0.0);
}
