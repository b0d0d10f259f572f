#version 460
// A box that the vertices' numbers make, or the sky around the eye.
layout(push_constant) uniform Push {
    mat4 to_clip;
    vec4 middle; // w: 1 for the sky
    vec4 half_edges;
    vec4 color;
};

#ifdef VERTEX
layout(location = 0) out vec3 position;
layout(location = 1) flat out vec3 normal;

void main() {
    int face = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;
    vec2 at = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1))[corner];
    float side = face < 3 ? 1.0 : -1.0;
    int axis = face % 3;
    vec3 place = axis == 0 ? vec3(side, at) : axis == 1 ? vec3(at.x, side, at.y) : vec3(at, side);
    normal = vec3(axis == 0, axis == 1, axis == 2) * side;
    position = middle.xyz + half_edges.xyz * place;
    gl_Position = to_clip * vec4(position, 1.0);
    if (middle.w != 0.0) gl_Position.z = 0.0; // infinitely far
}
#else
layout(location = 0) in vec3 position;
layout(location = 1) flat in vec3 normal;
layout(location = 0) out vec4 light;

const vec3 SUN = normalize(vec3(0.5, 0.55, -0.67));

vec3 sky(vec3 d) {
    if (dot(d, SUN) > 0.9997) return vec3(900.0);
    if (d.y < 0.0) return vec3(0.16, 0.15, 0.13) * (1.0 + 0.5 * d.y);
    return mix(vec3(0.85, 0.9, 1.0), vec3(0.22, 0.42, 0.9), sqrt(d.y));
}

void main() {
    if (middle.w != 0.0) {
        light = vec4(sky(normalize(position - middle.xyz)), 1.0);
        return;
    }
    vec3 albedo = color.rgb;
    if (half_edges.x > 10.0) { // the ground's tiles
        vec2 tile = floor(position.xz);
        albedo *= mod(tile.x + tile.y, 2.0) < 0.5 ? 1.0 : 0.7;
    }
    vec3 around = mix(vec3(0.12), vec3(0.5, 0.6, 0.8), 0.5 + 0.5 * normal.y);
    light = vec4(albedo * (around + 0.9 * max(dot(normal, SUN), 0.0)), 1.0);
}
#endif
