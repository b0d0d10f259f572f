#ifndef PICTURES_GLSL
#define PICTURES_GLSL
// The prefiltered pictures of a far drop (appearance.glsl).
layout(std430, set = 0, binding = 9) readonly buffer Pictures { uint pictures[]; };
#endif
