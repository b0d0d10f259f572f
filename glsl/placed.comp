#version 460
#extension GL_GOOGLE_include_directive : require
// Where the placed drops that the scene knows are in a frame, and how far they move while the shutter is open. One invocation a
// cluster: first the box around its drops, then, where that may be in view, each of them. See src/passes/placed.rs.
#include "by_texels.glsl"
#include "frame.glsl"
#include "pairs.glsl"
#include "placed_boxes.glsl"
#include "rain.glsl"
#include "view_volume.glsl"
#include "lens.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform PlacedPush {
    vec2 moved;       // seconds to the middle of the exposure, as a pair
    vec2 exposed;     // seconds of the scene's time for which the shutter is open, as a pair
    vec3 before_high; // what the camera has moved by the middle of the exposure, backwards
    uint clusters;
    vec3 before_low;
    uint boxes;       // place of the first cluster's box; NOTHING: there are none, and all drops are wanted
    vec3 camera_high; // how far the camera moves while the shutter is open, backwards
    uint has_motions; // 1: the drops' motions are wanted
    vec3 camera_low;
    float since;      // seconds from the time of the clusters to the middle of the exposure
    uint first;       // number of the first cluster of those that the buffers have: texels are those of all
} push;
const uint NOTHING = 0xffffffffu;

// A drop at time 0.
struct Known {
    vec3 high; // its centre, as a pair
    float radius;
    vec3 low;
    uint number; // in layers
    vec3 velocity_high; // as a pair
    uint place; // among the placed drops; NO_DROP: there is none
    vec3 velocity_low;
    uint unused;
};

// What holds the drops of a cluster at a time, and how fast they are.
struct KnownCluster {
    vec4 low; // the fourth: how far a drop reaches beyond its centre, at most
    vec4 high;
    vec4 slowest;
    vec4 fastest;
};

layout(std430, set = 0, binding = 1) readonly buffer KnownDrops { Known known[]; };
layout(std430, set = 0, binding = 2) readonly buffer KnownClusters { KnownCluster known_clusters[]; };
layout(set = 0, binding = 5) uniform usamplerBuffer known_texels;
layout(set = 0, binding = 6) uniform usamplerBuffer cluster_texels;
layout(std430, set = 0, binding = 3) writeonly buffer PlacedDrops { Placed placed[]; };
layout(std430, set = 0, binding = 4) writeonly buffer PlacedMotions { vec4 placed_motions[]; };

Known known_at(uint number) {
    if (BY_TEXELS == 0u) return known[number];
    int at = int(4u * (push.first * CLUSTER + number));
    uvec4 a = texelFetch(known_texels, at), b = texelFetch(known_texels, at + 1);
    uvec4 c = texelFetch(known_texels, at + 2), d = texelFetch(known_texels, at + 3);
    return Known(uintBitsToFloat(a.xyz), uintBitsToFloat(a.w), uintBitsToFloat(b.xyz), b.w,
                 uintBitsToFloat(c.xyz), c.w, uintBitsToFloat(d.xyz), d.w);
}

vec4 cluster_texel(int at) {
    return uintBitsToFloat(texelFetch(cluster_texels, at));
}

KnownCluster cluster_at(uint number) {
    if (BY_TEXELS == 0u) return known_clusters[number];
    int at = int(4u * (push.first + number));
    return KnownCluster(cluster_texel(at), cluster_texel(at + 1), cluster_texel(at + 2), cluster_texel(at + 3));
}

// The box around a cluster's drops while the shutter is open: as large as their velocities let it grow.
Placed box_of(KnownCluster c) {
    vec3 one = push.since * c.slowest.xyz, other = push.since * c.fastest.xyz;
    vec3 low = c.low.xyz + min(one, other), high = c.high.xyz + max(one, other);
    vec3 motion = max(abs(push.exposed.x * c.slowest.xyz + push.camera_high), abs(push.exposed.x * c.fastest.xyz + push.camera_high));
    vec3 rounded = 5e-7 * (abs(one) + abs(other));
    Box box = Box(low + push.before_high - 0.5 * motion - rounded, high + push.before_high + 0.5 * motion + rounded, c.low.w);
    return record_of_box(box);
}

// May a drop in a box be in view? A little more often than clusters.comp says so of the same box.
bool may_be_seen(Placed box) {
    vec3 center = relative_placed(Placed(box.high, vec3(0.0), 0u));
    float reach = box.high.w * 1.002 + 2e-5 * length(abs(center) + box.low);
    return meets_view(center, box.low, 1.001 * reach_from_box(center, box.low, reach));
}

void carry(Known drop) {
    Pair velocity = Pair(drop.velocity_high, drop.velocity_low);
    Pair moved = add_pairs(Pair(drop.high, drop.low), scale_pair(velocity, push.moved));
    Pair center = add_pairs(moved, Pair(push.before_high, push.before_low));
    placed[drop.place] = Placed(vec4(center.high, drop.radius), center.low, drop.number);
    if (push.has_motions == 0u) return;
    Pair motion = add_pairs(scale_pair(velocity, push.exposed), Pair(push.camera_high, push.camera_low));
    placed_motions[drop.place] = vec4(motion.high, 0.0);
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint cluster = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (cluster >= push.clusters) return;
    if (push.boxes != NOTHING) {
        Placed box = box_of(cluster_at(cluster));
        placed[push.boxes + cluster] = box;
        if (!may_be_seen(box)) return;
    }
    for (uint i = cluster * CLUSTER; i < cluster * CLUSTER + CLUSTER; ++i) {
        Known drop = known_at(i);
        if (drop.place != NO_DROP) carry(drop);
    }
}
