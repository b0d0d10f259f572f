// Radiance from a direction: a latitude-longitude texture whose levels are blurred equally in all
// directions (src/environment/levels.rs), so that one level serves from equator to pole.

const float PI = 3.14159265358979;

// Radiance, in stored units, from unit direction `d`, averaged over about `spread` radians.
// The level is computed: an implicit derivative is garbage in a point of one pixel.
vec3 radiance(sampler2D map, vec3 d, float spread) {
    vec2 uv = vec2(0.5 + atan(d.x, -d.z) / (2.0 * PI), acos(clamp(d.y, -1.0, 1.0)) / PI);
    return textureLod(map, uv, log2(max(spread, 1e-9) / frame.environment.x)).rgb;
}
