#ifndef HOST_RECORDS_GLSL
#define HOST_RECORDS_GLSL
// Drops of a host's in a buffer of its own, and how many they are: what the passes over them share. See src/passes/host_records.rs.
layout(std430, set = 0, binding = 1) readonly buffer Particles { uint particles[]; };
layout(std430, set = 0, binding = 2) readonly buffer ParticleCount { uint particle_count[]; };

// In the place of a word's number: there is none.
const uint NOTHING = 0xffffffffu;

// How many they say that they are: `count`, or the word at a place of its buffer.
uint claimed_count(uint count, uint at) {
    return at == NOTHING ? count : particle_count[at];
}

// A compiler may take it that no float is NaN; it cannot of bits.
bool is_finite(vec3 v) {
    return all(notEqual(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u)));
}
#endif
