#ifndef OCTAHEDRON_GLSL
#define OCTAHEDRON_GLSL
// Directions as texels of an octahedral map (Meyer et al. 2010), and a basis about each.
#include "constants.glsl"

// Where a direction is on the map, from -1 to 1.
vec2 octahedral(vec3 d) {
    vec2 p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    if (d.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return p;
}

// Number of the texel that holds unit direction `d`.
uint direction_texel(vec3 d) {
    vec2 p = octahedral(d);
    uvec2 at = uvec2(clamp((0.5 * p + 0.5) * float(DIRECTIONS), 0.0, float(DIRECTIONS) - 1.0));
    return at.y * DIRECTIONS + at.x;
}

// Unit direction at the middle of a texel.
vec3 texel_direction(uint texel) {
    vec2 at = vec2(texel % DIRECTIONS, texel / DIRECTIONS);
    vec2 p = (at + 0.5) * (2.0 / float(DIRECTIONS)) - 1.0;
    vec3 d = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (d.z < 0.0) d.xy = (1.0 - abs(d.yx)) * vec2(d.x >= 0.0 ? 1.0 : -1.0, d.y >= 0.0 ? 1.0 : -1.0);
    return normalize(d);
}

// Two unit vectors perpendicular to `n` and each other, for every n (Duff et al. 2017).
void basis(vec3 n, out vec3 u, out vec3 v) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z), b = n.x * n.y * a;
    u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    v = vec3(b, s + n.y * n.y * a, -n.y);
}
#endif
