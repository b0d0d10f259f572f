#version 460
#extension GL_GOOGLE_include_directive : require
// Which clusters of drops are in view, in bands of depth, and which of them above the image's middle; one
// invocation a cluster. See src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "clusters.glsl"

layout(local_size_x = 64) in;

#define COUNTERS_BINDING 11
#include "counters.glsl"

// Is any drop in view whose place from the camera is in the box? `middle`: of the box, on the side of those
// drops.
bool in_view(uvec3 low, uvec3 edges, out vec3 middle) {
    uvec3 high = low + edges;
    // A box that straddles the far side of the rain's has drops on both sides of the camera.
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
    middle = mix(center, -sign(frame.back.xyz) * half_size, straddles);
    return result;
}

void main() {
    // CPU drivers give each of their threads one part of the dispatch: each gets some of all parts of the
    // rain, of which only some are in view.
    uint stretch = gl_NumWorkGroups.x / STRETCHES;
    uint group = (gl_WorkGroupID.x % STRETCHES) * stretch + gl_WorkGroupID.x / STRETCHES;
    uint cluster = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (cluster >= CLUSTERS) return;

    // Drops placed by hand can be anywhere.
    uint band = BANDS - 1u;
    bool below = cluster % 2u == 0u;
    if (cluster < RANDOM_CLUSTERS) {
        uvec4 around = cluster_boxes[cluster];
        uvec3 edges = ((uvec3(around.w, around.w >> 10, around.w >> 20) & 1023u) + 1u << 22) - 1u;
        vec3 middle;
        if (!in_view(around.xyz + frame.shift.xyz - frame.camera_place.xyz, edges, middle)) return;
        // Bands have equal volumes in any pixel's view.
        float depth = -dot(frame.back.xyz, middle) / dot(abs(frame.back.xyz), frame.extent.xyz);
        band -= min(uint(pow(clamp(depth, 0.0, 1.0), 3.0) * float(BANDS)), BANDS - 1u);
        below = dot(frame.up.xyz, middle) < 0.0;
    }
    uint place;
    if (below) place = atomicAdd(totals.clusters[band].y, 1u);
    else place = atomicAdd(totals.clusters[band].x, 1u);
    if (place >= MAX_IN_VIEW) {
        atomicAdd(counters.lost, CLUSTER);
        return;
    }
    clusters_in_view[in_view_at(band, below, place)] = cluster;
    // As many workgroups of `gather` as begin.
    if (place % CLUSTERS_A_GROUP == 0u) atomicAdd(totals.gather_groups[band].x, 1u);
}
