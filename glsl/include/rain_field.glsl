// What a frame sees of real rain: `RainField`, written by src/passes/cells.rs.
const uint CELLS_GROUP = 64; // cells that a workgroup of cells.comp looks into, as in src/rain/field.rs
const uint MOST_CLASSES = 32, MOST_SLABS = 32768, LAW_WORDS = 128, QUANTILES = 65;

struct RainClass {
    uvec4 cell_low;  // low words of the number of the camera's cell; w: of the salt
    uvec4 cell_high; // high words; w: of the salt
    uvec4 fraction;  // the camera's place in its cell in units of 2^-32 of its edge; w: number of thresholds
    vec4 moved;      // xyz: how far drops move while the shutter is open, scene units; w: a cell's edge
    vec4 limits;     // how far drops reach from their centres at most, and the depth to which drops are shown one by one, scene units
};

// A layer of cells.
struct Slab {
    ivec3 first; // its first cell, relative to the camera's
    uint kind;
    uvec2 across; // cells along x and y
    uint cells;   // in all
    uint first_group;
};

layout(std430, set = 0, binding = 2) readonly buffer RainField {
    vec4 shown;          // cut-off in pixels, radius for a unit of diameter, squared distance to the rain's end
    uvec4 groups;        // x: of cells; y: placed drops
    vec4 band_depths[4]; // that part the drops into sixteen bands of equal number, nearest first
    vec4 medium;         // depth from which on all rain is medium, extinction a scene unit seen level, distance of the rain's
                         // end, extinction seen from below: over 0 where there is a medium
    vec4 depths[16];     // optical depth of the medium at 64 depths up to the first of these, equally far apart, seen level
    vec4 from_below[16]; // the same seen from below
    RainClass classes[MOST_CLASSES];
    uint laws[MOST_CLASSES * LAW_WORDS]; // of each class 65 quantiles of the diameter, then its thresholds
    Slab slabs[MOST_SLABS];
    uint group_slabs[];  // for each group of cells the number of its slab
} field;
