#version 460
#extension GL_GOOGLE_include_directive : require
// The mean light of bright sources in far rain with flattened drops: of its spheres by angle, of the others by direction
// from what flat_rays.comp has counted; one invocation an angle and source, or a direction. See src/passes/flat_light.rs.
#include "light_model.glsl"
#include "optics.glsl"
#include "octahedron.glsl"
#include "shape_surface.glsl"
#include "bow.glsl"

layout(local_size_x = 64) in;

#define SOURCES_BINDING 1
#include "sources.glsl"
#include "flat_rain.glsl"
layout(std430, set = 0, binding = 3) readonly buffer FlatSums { uint flat_sums[]; };
layout(std430, set = 0, binding = 4) readonly buffer Bow { vec4 bow[]; };
layout(std430, set = 0, binding = 5) writeonly buffer FlatLight { vec4 flat_light[]; };

const float HALF_TURN = 3.14159265;

// Of the octahedral map: a place at p of the octahedron is |p|^-3 of its part of the plane.
float solid_angle(uint texel) {
    vec3 d = texel_direction(texel, FLAT_DIRECTIONS), p = d / (abs(d.x) + abs(d.y) + abs(d.z));
    float edge = 2.0 / float(FLAT_DIRECTIONS), far = length(p);
    return edge * edge / (far * far * far);
}

// What a shape reflects on its outside along `d` of a source, over the source's light: of the one place that mirrors it
// there, by the curvature of the half that it is on.
float reflected(vec4 shape, vec3 d, vec3 toward) {
    vec3 between = toward - d;
    if (REFLECTION == 0u || dot(between, between) < 1e-8) return 0.0;
    vec3 normal = normalize(between);
    float high = normal.y > 0.0 ? shape.y : shape.z, ci = max(dot(normal, toward), 1e-4);
    vec3 axes = vec3(shape.x, high, shape.x), far = axes * normal;
    float root = shape.x * shape.x * high / dot(far, far); // of the curvature, over one
    float ct = sqrt(1.0 - (1.0 - ci * ci) / (WATER * WATER));
    return 0.25 * root * root * reflectance_of(ci, ct, WATER);
}

vec3 light_of_flat(uint texel) {
    vec3 d = texel_direction(texel, FLAT_DIRECTIONS), light = vec3(0.0);
    // A ray carries the light of its part of half an ellipse; what leaves is spread over all that is seen of the drops.
    float of_ray = 0.5 * HALF_TURN / (SUM_OF_ONE * float(FLAT_RAYS) * solid_angle(texel));
    for (uint source = 0u; source < source_count.x; ++source) {
        float sent = of_ray * float(flat_sums[source * FLAT_DIRECTIONS * FLAT_DIRECTIONS + texel]);
        for (uint i = 0u; i < FLAT_SHAPES; ++i) sent += reflected(flat_shapes[i], d, sources[source].toward.xyz);
        light += sent * sources[source].light.rgb;
    }
    float outlines = 0.0;
    for (uint i = 0u; i < FLAT_SHAPES; ++i) {
        float high = half_height(flat_shapes[i], true, d) + half_height(flat_shapes[i], false, d);
        outlines += 0.5 * HALF_TURN * flat_shapes[i].x * high;
    }
    return light / outlines;
}

void main() {
    uint entry = gl_GlobalInvocationID.x, flat_from = flat_light.length() - FLAT_DIRECTIONS * FLAT_DIRECTIONS;
    if (entry >= flat_light.length()) return;
    if (entry < flat_from) {
        flat_light[entry] = vec4(flat_round_share * bow[entry].rgb, float(flat_from));
    } else {
        flat_light[entry] = vec4((1.0 - flat_round_share) * light_of_flat(entry - flat_from), 0.0);
    }
}
