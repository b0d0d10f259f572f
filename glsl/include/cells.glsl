#ifndef CELLS_GLSL
#define CELLS_GLSL
// Real rain: each class of drops has cells that fall with it, and a cell's drops come from a hash of its number; the
// same as src/rain/cells.rs and src/rain/field.rs, bit for bit.
// The cell of a slab, relative to the camera's.
#include "rain.glsl"
#include "rain_field.glsl"

ivec3 cell_of(Slab slab, uint number) {
    uint layer = slab.across.x * slab.across.y, in_layer = number % layer;
    return slab.first + ivec3(in_layer % slab.across.x, in_layer / slab.across.x, number / layer);
}

// Four random words of a cell.
uvec4 key_of(uint kind, ivec3 cell) {
    uvec3 base = field.classes[kind].cell_low.xyz, carry;
    uvec3 low = uaddCarry(base, uvec3(cell), carry);
    // The offset's own high word: all ones below 0.
    uvec3 high = field.classes[kind].cell_high.xyz + uvec3(cell >> 31) + carry;
    uvec4 v = pcg4d(uvec4(low, field.classes[kind].cell_low.w));
    return pcg4d(v ^ uvec4(high, field.classes[kind].cell_high.w));
}

uint drops_in(uint kind, uvec4 key) {
    uint thresholds = field.classes[kind].fraction.w, count = 0u;
    while (count < thresholds && law_at(kind * LAW_WORDS + QUANTILES + count) <= key.w) ++count;
    return count;
}

// Diameter for 32 random bits: the first six choose a segment of the quantiles, the others a place in it.
uint diameter_of(uint kind, uint bits) {
    uint at = kind * LAW_WORDS + (bits >> 26), from = law_at(at), above, below;
    umulExtended(law_at(at + 1u) - from, bits << 6, above, below);
    return from + above;
}

// Where a drop of a cell is relative to the camera, along the world's axes, and its radius; scene units.
vec4 drop_of_key(uint kind, ivec3 cell, uvec4 key, uint number) {
    uvec4 words = pcg4d(uvec4(key.xyz, key.w + 1u + number));
    uvec3 from = field.classes[kind].fraction.xyz;
    ivec3 cells = cell - ivec3(lessThan(words.xyz, from));
    precise vec3 relative = (vec3(cells) + vec3(words.xyz - from) * (1.0 / 4294967296.0)) * field.classes[kind].moved.w;
    precise float radius = float(diameter_of(kind, words.w)) * field.shown.y;
    return vec4(relative, radius);
}

vec4 drop_in_cell(uint kind, ivec3 cell, uint number) {
    return drop_of_key(kind, cell, key_of(kind, cell), number);
}

float to_fourth(float value) {
    precise float square = value * value, fourth = square * square;
    return fourth;
}

// Is drop `number` of its cell shown by itself, or part of the medium? Of those that are too small for all to be shown some are
// (src/rain/thinned.rs).
bool shown_alone(uint kind, uint number, vec3 v, float radius, float distance2) {
    vec2 sizes = field.classes[kind].limits.zw;
    precise float size = radius * frame.image.z, least = sizes.x * -v.z, most = sizes.y * -v.z;
    if (size < least || distance2 > field.shown.z) return false;
    if (size >= most) return kind < field.groups.z;
    uint bits = pcg4d(uvec4(floatBitsToUint(radius), number, kind, 0x7468696eu)).x;
    precise float chance = float(bits >> 8) * (1.0 / 16777216.0), wanted = to_fourth(most) * chance;
    return wanted < to_fourth(size);
}
#endif
