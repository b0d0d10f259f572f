// A far drop's light from a source by the angle between them, which bow.comp finds at BOW_ANGLES angles.
#include "constants.glsl"

struct FarImages {
    vec4 mean;   // over the drop's disc
    vec4 first;  // the brightest image: light for a radius of a pixel; w: where it is, in radii towards the source
    vec4 second;
};
