#ifndef LIGHT_MODEL_GLSL
#define LIGHT_MODEL_GLSL
// What a drop does to a ray of light: `Light` in src/plan/light.rs. A pipeline that includes this has these
// constants first.
layout(constant_id = 0) const uint INTERNAL_REFLECTIONS = 2; // most that are followed
layout(constant_id = 1) const uint CONSERVING = 1; // 1: the last order takes what the omitted carry
layout(constant_id = 2) const uint SCHLICK = 0;
layout(constant_id = 3) const uint REFLECTION = 1;
layout(constant_id = 4) const uint FOOTPRINT = 1; // 0: the environment's finest level always
// Refractive index of the drops over that of what they are in, for red, green and blue light: the bits of floats, which
// the compiler can compare.
layout(constant_id = 5) const uint INDEX_RED = 0x3faa3d71u; // 1.33
layout(constant_id = 6) const uint INDEX_GREEN = 0x3faa3d71u;
layout(constant_id = 7) const uint INDEX_BLUE = 0x3faa3d71u;
// The finest picture of a far drop (src/passes/appearance.rs) has 2 to that many texels an edge: 16 or 32; 0: drops have one colour.
layout(constant_id = 36) const uint PICTURE_LEVEL = 4;
#endif
