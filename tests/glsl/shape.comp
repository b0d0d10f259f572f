#version 460
#extension GL_GOOGLE_include_directive : require
// A drop that is no sphere: what a ray through it meets, and its outline; see tests/drawn/shape_shader.rs.
#include "frame.glsl"
#include "projection.glsl"
#include "light_model.glsl"
#include "optics.glsl"

// In place of tile_buffers.glsl and drop_light.glsl.
#define TILE_BUFFERS_GLSL
const uint SPHERES = 0, SHAPE = 2;
#define DROP_LIGHT_GLSL
float least_rest() { return 1e-4; }

// In place of environment.glsl: where it is asked for radiance, and how wide.
#define ENVIRONMENT_GLSL
vec4 asked[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
uint times_asked = 0u;
#define sampler2D int
vec3 radiance(sampler2D map, vec3 d, float spread) {
    if (times_asked < 4u) asked[times_asked] = vec4(d, spread);
    ++times_asked;
    return vec3(equal(uvec3(times_asked), uvec3(1u, 2u, 3u)));
}

#include "shape.glsl"
#include "shape_light.glsl"

layout(local_size_x = 64) in;
// Three a drop: its shape; of a ray its offset from the centre, or the centre in view space; the ray's direction, or the
// radius.
layout(std430, set = 0, binding = 1) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Found { vec4 found[]; };

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at % 3u != 0u || at + 2u >= given.length()) return;
    vec4 shape = given[at], place = given[at + 1u], along = given[at + 2u];
    uint first = 4u * at;
    if (place.w == 0.0) {
        vec3 light = shape_light_by_index(false, 0, 0, shape, place.xyz, along.xyz, along.w);
        for (uint i = 0u; i < 3u; ++i) found[first + i] = asked[i];
        found[first + 3u] = vec4(light, front_of(shape, place.xyz, along.xyz));
    } else {
        ShapeOutline o = shape_outline_of(place.xyz, along.x, shape);
        found[first] = box_of(o);
        found[first + 1u] = vec4(o.upper.center, 0.5 * (area_of(o.upper) + area_of(o.lower)), depth_of_shape(along.x, shape));
        found[first + 2u] = vec4(on_disc(shape, along.yzw, normalize(place.xyz), vertical()), reach_of_shape(shape));
    }
}
