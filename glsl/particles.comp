#version 460
#extension GL_GOOGLE_include_directive : require
// A host's particles as placed drops: each is read from the host's buffer, held against the limits, and written as the frame's
// passes read it. One invocation a cluster, whose box it finds as well. See src/passes/particles.rs.
#include "frame.glsl"
#include "counters.glsl"
#include "host_records.glsl"
#include "pairs.glsl"
#include "rain.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform ParticlesPush {
    vec3 low;             // particles with a smaller coordinate are left out
    float largest_radius; // those with a larger radius, too
    vec3 high;            // and those with a larger coordinate
    float exposed;        // for how long the shutter is open, seconds of the scene's time
    vec3 camera_exposed;  // how far the camera moves while it is open
    float until;          // seconds to the end of the motion in records
    vec3 camera_until;    // how far the camera is from here then
    uint start;           // word of the first particle in its buffer
    uint stride;          // words from one particle to the next
    uint position;        // words from a particle's start; NOTHING: they have none
    uint radius;
    uint velocity;
    uint id;
    uint count;           // particles
    uint count_at;        // word of their count in its buffer; NOTHING: it is `count`
    uint capacity;        // particles that the buffer holds, at most `most`
    uint most;            // those that there are places for
    uint first;           // the first one's place among the placed drops
    uint boxes;           // that of the first cluster's box; NOTHING: there are no clusters
    uint number;          // in layers of a first one without an id
} push;

layout(std430, set = 0, binding = 3) writeonly buffer PlacedDrops { Placed placed[]; };
// `placed_motions` and `placed_moved` of the frame's passes, where they read them.
layout(std430, set = 0, binding = 4) writeonly buffer PlacedMotions { vec4 placed_motions[]; };
layout(std430, set = 0, binding = 5) writeonly buffer PlacedMoved { vec4 placed_moved[]; };
layout(constant_id = 14) const uint MOTION = 0;  // 1: the shutter may be open for a time
layout(constant_id = 22) const uint NEAREST = 0; // 1: the drops have records

vec3 floats_at(uint word) {
    return uintBitsToFloat(uvec3(particles[word], particles[word + 1u], particles[word + 2u]));
}

struct Particle {
    vec3 center; // in the middle of the exposure, as one sees it who stands where the camera is as the shutter opens
    vec3 lost;   // what float32 lost of it
    vec3 velocity;
    vec3 motion; // while the shutter is open, as the camera sees it
    float radius;
    bool fits;
};

Particle particle_at(uint number) {
    uint at = push.start + number * push.stride;
    vec3 position = floats_at(at + push.position);
    Particle p;
    p.radius = uintBitsToFloat(particles[at + push.radius]);
    p.velocity = push.velocity == NOTHING ? vec3(0.0) : floats_at(at + push.velocity);
    precise vec3 motion = p.velocity * push.exposed - push.camera_exposed;
    Pair center = add_pairs(Pair(position, vec3(0.0)), Pair(0.5 * motion, vec3(0.0)));
    p.motion = motion;
    p.center = center.high;
    p.lost = center.low;
    bool is_within = all(lessThanEqual(push.low, position)) && all(lessThanEqual(position, push.high));
    bool has_size = p.radius > 0.0 && p.radius <= push.largest_radius;
    p.fits = is_finite(position) && is_finite(vec3(p.radius)) && is_finite(p.velocity) && is_finite(p.center) && is_within && has_size;
    return p;
}

// A drop that no camera sees: as far behind this one as float32 tells from its place.
Placed unseen() {
    float far = 1e6 + length(frame.camera_high.xyz);
    return Placed(vec4(frame.camera_high.xyz + far * frame.back.xyz, 0.0), vec3(0.0), 0u);
}

// Writes a particle as the placed drop of a number among all of them.
void write_drop(Particle p, uint number) {
    uint at = push.first + number;
    uint id = push.id == NOTHING ? push.number + number : particles[push.start + number * push.stride + push.id];
    placed[at] = Placed(vec4(p.center, p.radius), p.lost, id);
    if (MOTION != 0u) placed_motions[at] = vec4(p.motion, 0.0);
    if (NEAREST != 0u) placed_moved[at] = vec4(p.velocity * push.until - push.camera_until, 0.0);
}

// Writes that there is no drop of a number.
void write_none(uint number) {
    placed[push.first + number] = unseen();
    if (MOTION != 0u) placed_motions[push.first + number] = vec4(0.0);
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint cluster = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x, first = cluster * CLUSTER;
    uint claimed = claimed_count(push.count, push.count_at), count = min(claimed, push.capacity), unfit = 0u;
    if (cluster == 0u) atomicAdd(counters.beyond, claimed - count);
    if (first >= push.most) return;
    Box box = NO_BOX;
    for (uint number = first; number < min(first + CLUSTER, push.most); ++number) {
        if (number >= count) {
            write_none(number);
            continue;
        }
        Particle p = particle_at(number);
        if (p.fits) {
            write_drop(p, number);
            box = box_with(box, p.center, p.motion, p.radius);
        } else {
            write_none(number);
            unfit++;
        }
    }
    if (unfit > 0u) atomicAdd(counters.unfit, unfit);
    if (push.boxes != NOTHING) placed[push.boxes + cluster] = box.reach > 0.0 ? record_of_box(box) : unseen();
}
