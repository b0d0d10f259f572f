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

// Where the drops of a cluster may be, from the camera along the world's axes, and how far they reach over it.
struct Around {
    vec3 center;
    vec3 half_size;
    float reach;
    vec3 middle; // on the side of the drops: in front of the camera, or behind
};

// Rounding must not lose a drop that `visibility` would show.
float with_rounding(float reach, vec3 size) {
    return reach * 1.001 + 1e-5 * length(size);
}

// Random drops: their box at tick 0, moved.
Around around_random(uint cluster) {
    uvec4 box = box_of(cluster);
    uvec3 edges = ((uvec3(box.w, box.w >> 10, box.w >> 20) & 1023u) + 1u << 22) - 1u;
    Population p = population_numbered(box.w >> 30);
    uvec3 low = box.xyz + p.shift.xyz - p.camera_place.xyz, high = low + edges;
    // A box that straddles the far side of the rain's has drops on both sides of the camera.
    bvec3 straddles = lessThan(ivec3(high), ivec3(low));
    vec3 from = mix(vec3(ivec3(low)), vec3(-2147483648.0), straddles) * p.units.xyz;
    vec3 to = mix(vec3(ivec3(high)), vec3(2147483648.0), straddles) * p.units.xyz;
    Around a;
    a.center = 0.5 * (from + to);
    a.half_size = 0.5 * (to - from) + 0.5 * abs(p.moved.xyz);
    a.reach = with_rounding(p.units.w, 2147483648.0 * p.units.xyz);
    a.middle = mix(a.center, -sign(frame.back.xyz) * a.half_size, straddles);
    return a;
}

// Placed drops: the box that holds them in this frame, a record after those of all of them (`records` in
// src/passes/placed.rs).
Around around_placed(uint number) {
    Placed box = placed_at(frame.shift.w - frame.camera_place.w + number);
    Around a;
    a.center = relative_placed(Placed(box.high, vec3(0.0), 0u));
    a.half_size = box.low;
    a.reach = with_rounding(box.high.w, abs(a.center) + a.half_size);
    a.middle = a.center;
    return a;
}

void main() {
    // CPU drivers give each of their threads one part of the dispatch: each gets some of all parts of the
    // rain, of which only some are in view.
    uint stretch = gl_NumWorkGroups.x / STRETCHES;
    uint group = (gl_WorkGroupID.x % STRETCHES) * stretch + gl_WorkGroupID.x / STRETCHES;
    uint cluster = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (cluster >= CLUSTERS) return;

    Around a;
    if (HAS_PLACED != 0u && cluster >= RANDOM_CLUSTERS) {
        a = around_placed(cluster - RANDOM_CLUSTERS);
    } else {
        a = around_random(cluster);
    }
    bool seen = meets_view(a.center, a.half_size, reach_from_box(a.center, a.half_size, a.reach));
    float depth = -dot(frame.back.xyz, a.middle);
    // Bands have equal volumes in any pixel's view.
    float share = clamp(depth / dot(abs(frame.back.xyz), frame.extent.xyz), 0.0, 1.0);
    uint band = BANDS - 1u - min(uint(pow(share, 3.0) * float(BANDS)), BANDS - 1u);
    uint region = region_at(a.middle, depth, a.reach);
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
