// A far drop's mean light from a source by the angle between them, which bow.comp finds at BOW_ANGLES angles.
#include "constants.glsl"
