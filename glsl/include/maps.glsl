#ifndef MAPS_GLSL
#define MAPS_GLSL
// The environment as drops see it; and whole, with its bright sources, as it is behind the drops.
layout(set = 1, binding = 9) uniform sampler2D environment_map;
layout(set = 1, binding = 10) uniform sampler2D whole_map;
#endif
