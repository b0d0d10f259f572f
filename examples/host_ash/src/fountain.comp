#version 460
// Drops of a fountain, each by its number and the time alone: thrown up by a jet, falling, rebounding from the ground, and thrown
// up again. Drops of a jet stand in the buffer as they leave it, so that neighbours there are neighbours in the air.
layout(local_size_x = 64) in;

struct Drop {
    vec3 position;
    float radius;
    vec3 velocity;
    uint id;
};
layout(std430, set = 0, binding = 0) writeonly buffer Drops {
    uint count;
    uint unused[7];
    Drop drops[];
};
layout(push_constant) uniform Push {
    float time;
    float radius; // of a drop of usual size
    uint all;
};

const uint JETS = 12u; // the last one is in the middle
const float GRAVITY = 9.81;
const vec3 MIDDLE = vec3(-0.25, 0.0, -1.5);

// Four numbers from 0 to 1 (`pcg4d` of Jarzynski and Olano 2020).
vec4 random(uint number, uint salt) {
    uvec4 v = uvec4(number, salt, number ^ 0x9e3779b9u, 7u) * 1664525u + 1013904223u;
    for (int i = 0; i < 2; ++i) {
        v.x += v.y * v.w;
        v.y += v.z * v.x;
        v.z += v.x * v.y;
        v.w += v.y * v.z;
        v ^= v >> 16;
    }
    return vec4(v) / 4294967296.0;
}

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number == 0u) count = all;
    if (number >= all) return;
    uint of_jet = (all + JETS - 1u) / JETS, jet = number / of_jet;
    vec4 chance = random(number, 0u);
    bool is_middle = jet == JETS - 1u;

    // The velocity with which it is thrown.
    float angle = 6.2831853 * float(jet) / float(JETS - 1u);
    vec2 outward = is_middle ? vec2(0.0) : vec2(cos(angle), sin(angle));
    float spread = is_middle ? 0.5 : 0.22, up = is_middle ? 6.2 : 4.9;
    vec3 velocity = vec3(spread * (chance.x - 0.5), up * (0.97 + 0.06 * chance.y), spread * (chance.z - 0.5));
    velocity.xz -= 0.6 * outward;
    vec3 place = MIDDLE + vec3(0.85 * outward.x, 0.0, 0.85 * outward.y);
    // Few are large.
    float own = radius * (0.6 + 0.8 * chance.w + 4.0 * pow(random(number, 1u).x, 20.0));

    // How long ago, and what the ground has done to it since: it throws back a third of the fall, and scatters.
    float period = 1.45 * 2.0 * up / GRAVITY; // all of a jet have one, so that they keep their order
    float age = period * fract(time / period + (float(number % of_jet) + 0.5) / float(of_jet));
    float flight = 2.0 * velocity.y / GRAVITY;
    for (uint bounce = 0u; bounce < 4u && age > flight; ++bounce) {
        vec4 how = random(number, 2u + bounce);
        age -= flight;
        place.xz += velocity.xz * flight;
        velocity.xz = 0.6 * velocity.xz + 0.5 * velocity.y * (how.xy - 0.5);
        velocity.y *= 0.2 + 0.2 * how.z;
        flight = 2.0 * velocity.y / GRAVITY;
    }
    age = min(age, flight); // it lies where it has come to rest
    place += velocity * age - vec3(0.0, 0.5 * GRAVITY * age * age, 0.0);
    velocity.y -= GRAVITY * age;
    drops[number] = Drop(place + vec3(0.0, own, 0.0), own, velocity, number + 1u);
}
