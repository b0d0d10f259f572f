#version 460
#extension GL_GOOGLE_include_directive : require
// A host's image of what is around the rain, as a latitude-longitude map: the finest level of both maps. CUBE: from a
// cube map. One invocation a texel. See src/passes/renewal.rs.
layout(local_size_x = 64) in;

#ifdef CUBE
layout(set = 0, binding = 0) uniform samplerCube host_image;
#else
layout(set = 0, binding = 0) uniform sampler2D host_image;
#endif
layout(set = 0, binding = 1, rgba16f) uniform writeonly image2D whole;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D rest;

#include "constants.glsl"

layout(push_constant) uniform RenewalPush {
    vec4 to_image[3]; // columns: from world space to the image's
    float scale;      // radiance of a 1
    uint edge;        // samples along an edge of a texel
};

const float PI = 3.14159265358979;

void main() {
    uvec2 size = uvec2(imageSize(whole));
    uint number = gl_GlobalInvocationID.x;
    if (number >= size.x * size.y) return;
    uvec2 at = uvec2(number % size.x, number / size.x);
    mat3 turn = mat3(to_image[0].xyz, to_image[1].xyz, to_image[2].xyz);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (uint i = 0u; i < edge * edge; ++i) {
        vec2 uv = (vec2(at) + (vec2(i % edge, i / edge) + 0.5) / float(edge)) / vec2(size);
        float azimuth = 2.0 * PI * (uv.x - 0.5), polar = PI * uv.y;
        vec3 d = turn * vec3(sin(polar) * sin(azimuth), cos(polar), -sin(polar) * cos(azimuth));
#ifdef CUBE
        vec3 light = textureLod(host_image, d, 0.0).rgb;
#else
        vec2 place = vec2(0.5 + atan(d.x, -d.z) / (2.0 * PI), atan(length(d.xz), d.y) / PI);
        vec3 light = textureLod(host_image, place, 0.0).rgb;
#endif
        // A texel that is no number, or negative, is black; one that is infinite, the brightest.
        light = mix(vec3(0.0), min(light * scale, float(MAX_STORED)), greaterThan(light, vec3(0.0)));
        sum += sin(polar) * light;
        weights += sin(polar);
    }
    vec4 texel = vec4(sum / weights, 1.0);
    imageStore(whole, ivec2(at), texel);
    imageStore(rest, ivec2(at), texel);
}
