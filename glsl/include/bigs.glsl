#ifndef BIGS_GLSL
#define BIGS_GLSL
// Drops that have more than MOST_TILES blocks: number, and how many blocks. Each has so many that there is room for all.
layout(std430, set = 1, binding = 6) buffer Bigs { uvec2 bigs[]; };
#endif
