#ifndef ENVIRONMENT_GLSL
#define ENVIRONMENT_GLSL
// Radiance from a direction: a latitude-longitude texture whose levels are blurred equally in all
// directions (src/environment/levels.rs), so that one level serves from equator to pole.
#include "frame.glsl"

const float PI = 3.14159265358979;

// Radiance, in stored units, from unit direction `d`, averaged over about `spread` radians.
// The level is computed: an implicit derivative is garbage in a point of one pixel. The polar angle
// is an atan and not acos(d.y): that loses half its digits at the poles, and drivers' acos is 5e-5 off.
vec3 radiance(sampler2D map, vec3 d, float spread) {
    vec2 uv = vec2(0.5 + atan(d.x, -d.z) / (2.0 * PI), atan(length(d.xz), d.y) / PI);
    return textureLod(map, uv, log2(max(spread, 1e-9) / frame.environment.x)).rgb;
}
#endif
