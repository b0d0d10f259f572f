#version 460
#extension GL_GOOGLE_include_directive : require
// Where flattened drops send the light of bright sources that enters them, all orders of it: rays from each source,
// counted by the direction in which a camera would see them; one invocation a ray and source. See src/passes/flat_light.rs.
#include "light_model.glsl"
#include "optics.glsl"
#include "octahedron.glsl"
#include "shape_surface.glsl"

layout(local_size_x = 64) in;

#define SOURCES_BINDING 1
#include "sources.glsl"
#include "flat_rain.glsl"
layout(std430, set = 0, binding = 3) buffer FlatSums { uint flat_sums[]; };

void count(uint source, vec3 toward, float share) {
    uint texel = source * FLAT_DIRECTIONS * FLAT_DIRECTIONS + direction_texel(-toward, FLAT_DIRECTIONS);
    atomicAdd(flat_sums[texel], uint(share * SUM_OF_ONE + 0.5));
}

// `p`: from the middle of the joint to the ray, whose light is `light`.
void follow(uint source, vec4 shape, vec3 p, vec3 d, float light) {
    vec3 scale = scale_of(shape, upper_met(shape, p, d).x);
    float along;
    vec3 at = crossing(p, d, scale, -1.0, along), normal = normalize(at * scale * scale);
    float ci = clamp(-dot(d, normal), 1e-4, 1.0), ratio = 1.0 / WATER;
    float ct = sqrt(1.0 - (1.0 - ci * ci) * ratio * ratio), f = reflectance_of(ci, ct, WATER);
    float left = light * (1.0 - f);
    vec3 w = normalize(ratio * d + (ratio * ci - ct) * normal);
    for (uint k = 0u; k < MOST_MORE; ++k) {
        scale = scale_of(shape, upper_met(shape, at, w).y);
        at = crossing(at, w, scale, 1.0, along);
        normal = normalize(at * scale * scale);
        ci = clamp(dot(w, normal), 1e-4, 1.0);
        ct = sqrt(max(1.0 - (1.0 - ci * ci) * WATER * WATER, 0.0));
        f = reflectance_of(ci, ct, ratio);
        if (f < 1.0) count(source, normalize(WATER * w - (WATER * ci - ct) * normal), left * (1.0 - f));
        left *= f;
        if (left < LEAST_REST * light) break;
        w = normalize(w - 2.0 * ci * normal);
    }
}

void main() {
    uint ray = gl_GlobalInvocationID.x, source = gl_GlobalInvocationID.y;
    if (source >= source_count.x) return;
    vec4 shape = flat_shapes[ray % FLAT_SHAPES];
    bool upper = ray / FLAT_SHAPES % 2u == 0u;
    uint number = ray / (2u * FLAT_SHAPES);
    vec3 d = -sources[source].toward.xyz;
    float cosine = length(d.xz), high = half_height(shape, upper, d);
    vec3 right = cosine > 1e-6 ? vec3(-d.z, 0.0, d.x) / cosine : vec3(1.0, 0.0, 0.0), upwards = cross(right, d);
    // Evenly over half an ellipse: turns by the golden angle, otherwise begun for each shape.
    float far = sqrt((float(number) + 0.5) / float(FLAT_RAYS));
    float turn = 3.14159265 * fract(0.61803399 * float(number) + 0.38196601 * float(ray % (2u * FLAT_SHAPES)));
    vec3 at = far * (shape.x * cos(turn) * right + (upper ? high : -high) * sin(turn) * upwards);
    follow(source, shape, at, d, high * shape.x);
}
