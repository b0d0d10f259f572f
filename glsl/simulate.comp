#version 460
#extension GL_GOOGLE_include_directive : require
// Where every drop is and whether it is in view; one invocation a drop. The twin of src/rain.rs and
// src/cull.rs, bit for bit: see src/passes/simulate.rs.
#include "frame.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint STORED = 0; // 1: the paper's stored positions
layout(constant_id = 1) const uint MAX_LARGE = 1;

layout(push_constant) uniform Push {
    uint first;  // index of the first drop of this chunk
    uint length; // number of drops in this chunk
};

struct Placed {
    vec4 high; // centre in float32, radius
    vec4 low;  // what float32 lost of the centre
};

// Drops as the draw reads them: centre in view space, radius; radius 0: nothing to draw.
layout(std430, set = 0, binding = 1) writeonly buffer Drops { vec4 drops[]; };
layout(std430, set = 0, binding = 2) readonly buffer PlacedDrops { Placed placed[]; };
// Positions of the paper's model, in the rain box; unused otherwise.
layout(std430, set = 0, binding = 3) buffer Stored { vec4 stored[]; };
// Drops too large for a point, unordered.
layout(std430, set = 0, binding = 4) writeonly buffer Large { vec4 large[]; };
layout(std430, set = 0, binding = 5) writeonly buffer LargeIndex { uint large_index[]; };
layout(std430, set = 0, binding = 6) buffer Counters {
    uint large_count;
    uint camera_inside;
    uint beside_camera;
    uint spare;
    uint visible[64]; // a slot a workgroup, modulo: one counter would be fought over
} counters;

uvec3 start(uint index) {
    // pcg4d, Jarzynski and Olano 2020.
    uvec4 v = uvec4(index, frame.seed.xy, 0x7261696eu) * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v.xyz;
}

// Centre relative to the camera along the world's axes. `precise` keeps every product and sum apart,
// so that each rounds as the CPU's does.
vec3 relative_integer(uint index) {
    ivec3 place = ivec3(start(index) + frame.shift.xyz - frame.camera_place.xyz);
    precise vec3 relative = vec3(place) * frame.units.xyz;
    return relative;
}

vec3 wrap(vec3 p) {
    vec3 box = frame.extent.xyz;
    return p - 2.0 * box * floor((p + box) / (2.0 * box));
}

vec3 relative_stored(uint index, uint slot) {
    vec3 p;
    if (frame.seed.z != 0u) {
        p = vec3(ivec3(start(index) + frame.shift.xyz)) * frame.units.xyz;
    } else {
        p = wrap(stored[slot].xyz + frame.motion.xyz);
    }
    stored[slot] = vec4(p, 0.0);
    return wrap(p - frame.camera_high.xyz);
}

vec3 relative_placed(Placed drop) {
    precise vec3 relative =
        (drop.high.xyz - frame.camera_high.xyz) + (drop.low.xyz - frame.camera_low.xyz);
    return relative;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= length) return;
    uint index = first + slot;

    vec3 p;
    float radius;
    if (index < frame.camera_place.w) {
        p = STORED != 0u ? relative_stored(index, slot) : relative_integer(index);
        radius = frame.units.w;
    } else {
        Placed drop = placed[index - frame.camera_place.w];
        p = relative_placed(drop);
        radius = drop.high.w;
    }

    precise vec3 v = vec3(
        (frame.right.x * p.x + frame.right.y * p.y) + frame.right.z * p.z,
        (frame.up.x * p.x + frame.up.y * p.y) + frame.up.z * p.z,
        (frame.back.x * p.x + frame.back.y * p.y) + frame.back.z * p.z);
    precise float depth = -v.z;
    precise float distance2 = (v.x * v.x + v.y * v.y) + v.z * v.z;
    precise float radius2 = radius * radius;
    precise float beyond_x = abs(v.x) * frame.frustum.x - depth * frame.frustum.y;
    precise float beyond_y = abs(v.y) * frame.frustum.z - depth * frame.frustum.w;
    precise float near2 = frame.camera_high.w * frame.camera_high.w;

    bool inside = distance2 <= radius2;
    bool in_frustum = beyond_x <= radius && beyond_y <= radius;
    bool beside = depth <= radius;
    bool visible = !inside && in_frustum && !beside && distance2 >= near2;

    if (inside) atomicAdd(counters.camera_inside, 1u);
    else if (beside && in_frustum && distance2 >= near2 && depth > -radius)
        atomicAdd(counters.beside_camera, 1u);

    if (visible) {
        atomicAdd(counters.visible[gl_WorkGroupID.x & 63u], 1u);
        // Point sizes over the limit are silently clamped by drivers: those drops become quads.
        float flat2 = depth * depth - radius2;
        float diameter = 2.0 * frame.image.z * radius * sqrt(sqrt(distance2 - radius2))
                         / (sqrt(sqrt(flat2)) * sqrt(flat2));
        if (!(diameter <= frame.image.w)) {
            uint at = atomicAdd(counters.large_count, 1u);
            if (at < MAX_LARGE) {
                large[at] = vec4(v, radius);
                large_index[at] = index;
            }
            visible = false;
        }
    }
    drops[slot] = vec4(v, visible ? radius : 0.0);
}
