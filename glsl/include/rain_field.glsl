#ifndef RAIN_FIELD_GLSL
#define RAIN_FIELD_GLSL
// What a frame sees of real rain: `RainField`, written by src/passes/cells.rs.
#include "constants.glsl"
#include "by_texels.glsl"

// A drop's number: that of its cell among all that are looked into, times 64, and its own in the cell; from
// IS_PLACED on that of a drop placed by hand.

struct RainClass {
    uvec4 cell_low;  // low words of the number of the camera's cell; w: of the salt
    uvec4 cell_high; // high words; w: of the salt
    uvec4 fraction;  // the camera's place in its cell in units of 2^-32 of its edge; w: number of thresholds
    vec4 moved;      // xyz: how far drops move while the shutter is open, scene units; w: a cell's edge
    vec4 limits;     // how far drops reach from their centres at most, and the depth to which drops are shown one by one, scene units;
                     // radii in pixels of the least drop that is shown, and of the least of which all are
};

// A layer of cells.
struct Slab {
    ivec3 first; // its first cell, relative to the camera's
    uint kind;
    uvec2 across; // cells along x and y
    uint cells;   // in all
    uint first_group;
};

layout(std140, set = 0, binding = 2) uniform RainField {
    vec4 shown;          // radius in pixels under which drops are thinned, radius for a unit of diameter, squared distance to the rain's end; diameter in mm
                         // for a radius of 1
    uvec4 groups;        // x: of cells; y: placed drops; z: classes of the rain's own, which others follow
    vec4 band_depths[MAX_BANDS / 4u]; // that part the drops into the bands of equal number, nearest first
    vec4 medium;         // depth from which on all rain is medium, extinction a scene unit seen level, distance of the rain's
                         // end, extinction seen from below: over 0 where there is a medium
    uvec4 grain_base;    // its noise (src/rain/grain.rs), of a lattice: number of the camera's cell; w: of the salt
    vec4 grain_within;   // where in it; w: depth from which on there is a medium, 0: no noise
    vec4 grain_scale;    // xyz: cells from the camera to where the noise is
    RainClass classes[MOST_CLASSES];
} field;

// What is too large for a uniform buffer.
layout(std430, set = 0, binding = 16) readonly buffer RainTables {
    uint laws[MOST_CLASSES * LAW_WORDS]; // of each class 65 quantiles of the diameter, then its thresholds
    Slab slabs[MOST_SLABS];
    vec4 medium[MEDIUM_DEPTHS]; // optical depth of the medium at so many depths up to the first of `field.medium`, equally far apart, seen level
                                // and from below; its variance on the axis, by the cube root of the inverse depth
    vec4 flat_suns[FLAT_SUN_ANGLES * FLAT_SUN_ANGLES * FLAT_SUN_ANGLES]; // what flattened drops show of a source (flat_suns.glsl)
    vec4 flat_shares[2u * FLAT_ELEVATIONS]; // what part of the medium is drops of which diameter (flat_light.glsl); of drops shown one by one
    uint group_slabs[];  // for each group of cells the number of its slab
} tables;

// Its words, and four of them at a time.
layout(set = 0, binding = 17) uniform usamplerBuffer table_words;
layout(set = 0, binding = 18) uniform usamplerBuffer table_texels;

uint law_at(uint word) {
    return BY_TEXELS != 0u ? texelFetch(table_words, int(word)).x : tables.laws[word];
}

Slab slab_at(uint number) {
    if (BY_TEXELS == 0u) return tables.slabs[number];
    int at = int(MOST_CLASSES * LAW_WORDS / 4u + 2u * number);
    uvec4 first = texelFetch(table_texels, at), rest = texelFetch(table_texels, at + 1);
    return Slab(ivec3(first.xyz), first.w, rest.xy, rest.z, rest.w);
}

// A row of the table of the medium.
vec4 medium_at(uint number) {
    const int FIRST = int(MOST_CLASSES * LAW_WORDS / 4u + 2u * MOST_SLABS);
    return BY_TEXELS != 0u ? uintBitsToFloat(texelFetch(table_texels, FIRST + int(number))) : tables.medium[number];
}

// An entry of `flat_suns`.
vec4 flat_sun_at(uint entry) {
    const int FIRST = int(MOST_CLASSES * LAW_WORDS / 4u + 2u * MOST_SLABS + MEDIUM_DEPTHS);
    return BY_TEXELS != 0u ? uintBitsToFloat(texelFetch(table_texels, FIRST + int(entry))) : tables.flat_suns[entry];
}

// The slab of a group of cells.
Slab slab_of_group(uint group) {
    const uint FIRST = MOST_CLASSES * LAW_WORDS + 8u * MOST_SLABS
        + 4u * (MEDIUM_DEPTHS + FLAT_SUN_ANGLES * FLAT_SUN_ANGLES * FLAT_SUN_ANGLES + 2u * FLAT_ELEVATIONS);
    return slab_at(BY_TEXELS != 0u ? texelFetch(table_words, int(FIRST + group)).x : tables.group_slabs[group]);
}
#endif
