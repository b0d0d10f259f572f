#ifndef FLATTENED_GLSL
#define FLATTENED_GLSL
// The mean light of a flattened drop, and how a sphere's picture on its outline is made as light.
#include "constants.glsl"
#include "shared_exponent.glsl"
#include "tile_buffers.glsl"

// By how much a drop of a diameter in mm is lower than wide (src/rain/shape.rs: Beard and Chuang 1987).
float flatness_of(float mm) {
    float d = min(mm, 6.0);
    return d > float(SMALLEST_MM) ? -4.8e-3 - d * (5.7e-4 + d * (-2.628e-2 + d * (3.682e-3 - d * 1.677e-4))) : 0.0;
}

// Which of the diameters of flattened drops, 3 and 6 mm, splats are between: by number, and their flatness.
const uvec2 FLAT_SPLATS = uvec2(1u, 3u);
const vec2 FLATNESS = vec2(0.1442, 0.3599);

// Mean light of a drop so flat, by that of drops of those two diameters: two words of the splats' table.
vec3 flat_splats_light(uvec2 words, float flatness) {
    float from_first = clamp((flatness - FLATNESS.x) / (FLATNESS.y - FLATNESS.x), 0.0, 1.0);
    precise vec3 light = mix(unpack_radiance(words.x), unpack_radiance(words.y), from_first);
    return light;
}

// Mean light of a drop between a sphere, whose light is `round`, and one so flat.
vec3 flattened_light(vec3 round, vec3 of_flat, float flatness) {
    // Totally reflected light grows faster than flatness.
    precise float from_round = min(flatness / FLATNESS.x, 1.0);
    precise vec3 light = mix(round, of_flat, from_round * sqrt(from_round));
    return light;
}

// Mean light of such a drop by that of drops of 2, 3, 4 and 6 mm: four words of flat_light.comp.
vec3 light_of_flatness(vec3 round, uvec4 words, float flatness) {
    const vec4 AT = vec4(0.0724, FLATNESS.x, 0.2207, FLATNESS.y);
    float from_round = min(flatness / AT.x, 1.0);
    uint above = flatness > AT.z ? 3u : flatness > AT.y ? 2u : 1u;
    float from_below = clamp((flatness - AT[above - 1u]) / (AT[above] - AT[above - 1u]), 0.0, 1.0);
    vec3 of_flat = mix(unpack_radiance(words[above - 1u]), unpack_radiance(words[above]), from_below);
    return mix(round, of_flat, from_round * sqrt(from_round));
}

// How the light of a sphere's picture is made that of the drop, for the means of its upper and its lower half. Packed, for registers.
struct Lightened {
    uvec4 halves; // factors of the picture's light, of both halves; radiances that are added
    uint upright; // in the picture
};

// Times as light as its sphere's a place may become. All that a half lacks, added, would make a pale disc of a drop in a dark room,
// which shows windows along its rim; all of it as a factor would take the sphere's bright places for the drop's.
const float MOST_LIGHTENED = 2.0;

// A sphere shows its picture as it is.
Lightened not_flattened() {
    uint whole = pack_radiance(vec3(1.0)), none = pack_radiance(vec3(0.0));
    return Lightened(uvec4(whole, whole, none, none), 0u);
}

// Radiances are means over the halves of the outline.
uvec4 pack_lightened(vec3 sphere[2], vec3 drop[2]) {
    uvec4 words;
    for (uint i = 0u; i < 2u; ++i) {
        vec3 share = min(drop[i] / max(sphere[i], 1e-30), MOST_LIGHTENED);
        words[i] = pack_radiance(share);
        words[2u + i] = pack_radiance(max(drop[i] - share * sphere[i], 0.0));
    }
    return words;
}

// At a place on the disc. A half disc's middle is 4/3π from the whole one's: between the two it is linear.
vec3 lightened(vec3 light, Lightened l, vec2 on_disc) {
    if (SHAPE == SPHERES) return light;
    float lower = clamp(0.5 - 1.178 * dot(on_disc, unpackSnorm2x16(l.upright)), 0.0, 1.0);
    return light * mix(unpack_radiance(l.halves.x), unpack_radiance(l.halves.y), lower)
        + mix(unpack_radiance(l.halves.z), unpack_radiance(l.halves.w), lower);
}
#endif
