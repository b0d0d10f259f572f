#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// Which cells of the rain box are in view, and the drops in them; one invocation a cell, a dispatch a
// band of distance, the farthest first. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 14) const uint GRID_BITS = 1;  // the box has 2^GRID_BITS cells an edge
layout(constant_id = 15) const uint CELL_COUNT = 1; // all of them, and one for the placed drops

#define COUNTERS_BINDING 13
#include "counters.glsl"
// Where cells stand as seen from the camera's, numbered as cells are; band by band.
layout(std430, set = 0, binding = 14) readonly buffer FarToNear { uint far_to_near[]; };

layout(push_constant) uniform Push { uint band, first, end; } push;

// Is any drop in view whose place from the camera is within a cell's edge above `low`?
bool in_view(uvec3 low, uint edge) {
    uvec3 high = low + (edge - 1u);
    // A cell that straddles the far side of the box has drops on both sides of the camera.
    bvec3 straddles = lessThan(ivec3(high), ivec3(low));
    vec3 from = mix(vec3(ivec3(low)), vec3(-2147483648.0), straddles) * frame.units.xyz;
    vec3 to = mix(vec3(ivec3(high)), vec3(2147483648.0), straddles) * frame.units.xyz;
    vec3 center = 0.5 * (from + to), half_size = 0.5 * (to - from);
    // Rounding must not lose a drop that `sighting` would show.
    float reach = frame.units.w * 1.001 + 1e-5 * length(frame.extent.xyz);
    vec3 planes[5] = vec3[5](
        frame.frustum.x * frame.right.xyz + frame.frustum.y * frame.back.xyz,
        -frame.frustum.x * frame.right.xyz + frame.frustum.y * frame.back.xyz,
        frame.frustum.z * frame.up.xyz + frame.frustum.w * frame.back.xyz,
        -frame.frustum.z * frame.up.xyz + frame.frustum.w * frame.back.xyz,
        frame.back.xyz);
    bool result = true;
    for (uint i = 0u; i < 5u; ++i) {
        result = result && dot(planes[i], center) - dot(abs(planes[i]), half_size) <= reach;
    }
    return result;
}

void main() {
    uint at = push.first + gl_GlobalInvocationID.x;
    if (at >= push.end) return;
    uint band_start = 0u;
    if (push.band > 0u) band_start = totals.record_ends[push.band - 1u];
    // Of a band without a drop as well.
    if (at == push.first) atomicMax(totals.record_ends[push.band], band_start);

    uint cell = far_to_near[at];
    const uint SHIFT = 32u - GRID_BITS, MASK = (1u << GRID_BITS) - 1u;
    uvec3 from_camera = uvec3(cell, cell >> GRID_BITS, cell >> (2u * GRID_BITS)) & MASK;
    uvec3 origin = frame.shift.xyz - frame.camera_place.xyz;
    // The last cell holds the drops placed by hand, which can be anywhere.
    bool shown = true;
    if (cell + 1u < CELL_COUNT) {
        shown = in_view((from_camera << SHIFT) + (origin & ((1u << SHIFT) - 1u)), 1u << SHIFT);
        uvec3 place = (from_camera - (origin >> SHIFT)) & MASK;
        cell = place.x | place.y << GRID_BITS | place.z << (2u * GRID_BITS);
    }
    uint first = cell_first[cell], count = cell_first[cell + 1u] - first;
    if (count == 0u || !shown) return;
    // One atomic a subgroup: all cells add to the same counter.
    uint record = 0u, before = subgroupExclusiveAdd(count), all_here = subgroupAdd(count);
    if (subgroupElect()) {
        record = atomicAdd(totals.records, all_here);
        uint end = min(record + all_here, MAX_RECORDS);
        atomicMax(totals.record_ends[push.band], end);
        atomicMax(totals.record_groups[push.band].x, (end - min(band_start, end) + 255u) / 256u);
    }
    record = subgroupBroadcastFirst(record) + before;
    uint room = MAX_RECORDS - min(record, MAX_RECORDS);
    if (count > room) {
        atomicAdd(counters.lost, count - room);
        count = room;
    }
    for (uint i = 0u; i < count; ++i) record_index[record + i] = drop_order[first + i];
}
