#ifndef FLAT_SUNS_GLSL
#define FLAT_SUNS_GLSL
// What far rain with flattened drops shows of a bright source (src/rain/flat_suns.rs).
// Mean light of a source in far rain, in a unit direction in world space: of all drops, or of those shown one by one.
#include "flat_rain.glsl"
#include "source_light.glsl"

vec3 rain_light_of_source(uint source, vec3 d, bool one_by_one) {
    vec3 of_spheres = light_of_source(source, d), toward = source_at(source).toward.xyz;
    if (FLAT_RAIN == 0u) return of_spheres;
    const float HALF_TURN = 3.14159265;
    const uint LAST = FLAT_SUN_ANGLES - 1u;
    float across = length(d.xz) * length(toward.xz);
    float azimuth = across > 0.0 ? acos(clamp(dot(d.xz, toward.xz) / across, -1.0, 1.0)) : 0.0;
    vec2 elevations = asin(clamp(vec2(toward.y, d.y), -1.0, 1.0));
    vec3 at = (vec3(elevations, azimuth) / HALF_TURN + vec3(0.5, 0.5, 0.0)) * float(LAST);
    vec3 from = clamp(floor(at), 0.0, float(LAST) - 1.0), share = at - from;
    vec2 shown = vec2(0.0); // the part of spheres' light, with the colours of their bows; besides
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, i >> 1 & 1u, i >> 2), node = uvec3(from) + corner;
        vec3 weights = mix(1.0 - share, share, vec3(corner));
        uint entry = (node.x * FLAT_SUN_ANGLES + node.y) * FLAT_SUN_ANGLES + node.z;
        vec4 of_node = flat_sun_at(entry);
        shown += weights.x * weights.y * weights.z * (one_by_one ? of_node.zw : of_node.xy);
    }
    return shown.x * of_spheres + shown.y * source_at(source).light.rgb;
}
#endif
