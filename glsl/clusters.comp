#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// Which clusters of drops are in view, and in which bin: band of depth, and region of the image. One invocation a
// cluster. See src/passes/tiles.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "tile_buffers.glsl"
#include "rain.glsl"
#include "box_population.glsl"
#include "view_volume.glsl"
#include "lens.glsl"
#include "together.glsl"

layout(local_size_x = 64) in;

// Is any drop in view whose place from the camera is in the box? `middle`: of the box, on the side of those
// drops.
bool in_view(Population p, uvec3 low, uvec3 edges, out vec3 middle) {
    uvec3 high = low + edges;
    // A box that straddles the far side of the rain's has drops on both sides of the camera.
    bvec3 straddles = lessThan(ivec3(high), ivec3(low));
    vec3 from = mix(vec3(ivec3(low)), vec3(-2147483648.0), straddles) * p.units.xyz;
    vec3 to = mix(vec3(ivec3(high)), vec3(2147483648.0), straddles) * p.units.xyz;
    vec3 center = 0.5 * (from + to), half_size = 0.5 * (to - from);
    half_size += 0.5 * abs(p.moved.xyz);
    // Rounding must not lose a drop that `visibility` would show.
    float reach = p.units.w * 1.001 + 1e-5 * length(frame.extent.xyz);
    bool result = meets_view(center, half_size, reach_from_box(center, half_size, reach));
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
    uint band = BANDS - 1u, region = cluster % MAX_REGIONS * REGIONS / MAX_REGIONS;
    bool seen = true;
    if (cluster < RANDOM_CLUSTERS) {
        uvec4 around = cluster_boxes[cluster];
        uvec3 edges = ((uvec3(around.w, around.w >> 10, around.w >> 20) & 1023u) + 1u << 22) - 1u;
        vec3 middle;
        Population p = population_numbered(around.w >> 30);
        seen = in_view(p, around.xyz + p.shift.xyz - p.camera_place.xyz, edges, middle);
        float depth = -dot(frame.back.xyz, middle);
        // Bands have equal volumes in any pixel's view.
        float share = clamp(depth / dot(abs(frame.back.xyz), frame.extent.xyz), 0.0, 1.0);
        band -= min(uint(pow(share, 3.0) * float(BANDS)), BANDS - 1u);
        region = region_at(middle, depth, p.units.w);
    }
    uvec4 seen_here = subgroupBallot(seen);
    uint number = 0u, count = subgroupBallotBitCount(seen_here), before = subgroupBallotExclusiveBitCount(seen_here);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.in_view, count, leads, number);
    if (!seen) return;
    number += before;
    uint bin = band * REGIONS + region, at = found_at(number);
    clusters_in_view[at] = cluster;
    clusters_in_view[at + 1u] = bin;
    clusters_in_view[at + 2u] = atomicAdd(totals.bin_counts[bin], 1u);
}
