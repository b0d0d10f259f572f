// A far drop's mean light from a source by the angle between them, which bow.comp finds at BOW_ANGLES angles. If there are
// flattened drops, of spheres so much as they block, and after that the light of the others by direction; the first
// entry's w is where that begins (flat_light.comp), else 0.
#include "constants.glsl"
