#ifndef FLATTENED_GLSL
#define FLATTENED_GLSL
// The mean light of a flattened drop, and how a sphere's picture on its outline is made as light.
#include "constants.glsl"
#include "shared_exponent.glsl"

// By how much a drop of a diameter in mm is lower than wide (src/rain/shape.rs: Beard and Chuang 1987).
float flatness_of(float mm) {
    float d = min(mm, 6.0);
    return d > float(SMALLEST_MM) ? -4.8e-3 - d * (5.7e-4 + d * (-2.628e-2 + d * (3.682e-3 - d * 1.677e-4))) : 0.0;
}

// Which of the diameters of flattened drops, 3 and 6 mm, splats are between: by number, and their flatness.
const uvec2 FLAT_SPLATS = uvec2(1u, 3u);
const vec2 FLATNESS = vec2(0.1442, 0.3599);

// Mean light of a drop so flat, by that of a sphere and of drops of those two diameters.
vec3 flattened_light(vec3 round, vec3 first, vec3 second, float flatness) {
    float from_first = clamp((flatness - FLATNESS.x) / (FLATNESS.y - FLATNESS.x), 0.0, 1.0);
    // Totally reflected light grows faster than flatness.
    precise float from_round = min(flatness / FLATNESS.x, 1.0);
    precise vec3 light = mix(round, mix(first, second, from_first), from_round * sqrt(from_round));
    return light;
}

// The same, by that of drops of 2, 3, 4 and 6 mm: four words of flat_light.comp.
vec3 light_of_flatness(vec3 round, uvec4 words, float flatness) {
    const vec4 AT = vec4(0.0724, FLATNESS.x, 0.2207, FLATNESS.y);
    float from_round = min(flatness / AT.x, 1.0);
    uint above = flatness > AT.z ? 3u : flatness > AT.y ? 2u : 1u;
    float from_below = clamp((flatness - AT[above - 1u]) / (AT[above] - AT[above - 1u]), 0.0, 1.0);
    vec3 of_flat = mix(unpack_radiance(words[above - 1u]), unpack_radiance(words[above]), from_below);
    return mix(round, of_flat, from_round * sqrt(from_round));
}

// What is lacking is added evenly: bright places of the sphere's are none of the drop's.
struct Lightened {
    vec3 share, more; // of the picture's light; radiance
};

// Two words for `LargeShape`. Both radiances are means over the outline.
uvec2 pack_lightened(vec3 of_sphere, vec3 of_drop) {
    vec3 share = min(of_drop / max(of_sphere, 1e-30), 1.0);
    return uvec2(pack_radiance(share), pack_radiance(max(of_drop - of_sphere, 0.0)));
}

Lightened unpack_lightened(uvec2 words) {
    return Lightened(unpack_radiance(words.x), unpack_radiance(words.y));
}

vec3 lightened(vec3 light, Lightened l) {
    return light * l.share + l.more;
}
#endif
