#ifndef SPLAT_TABLE_GLSL
#define SPLAT_TABLE_GLSL
// What splats show (splat_table.comp).
#ifndef SPLAT_TABLE_ACCESS
#define SPLAT_TABLE_ACCESS readonly
#endif
layout(std430, set = 1, binding = 5) SPLAT_TABLE_ACCESS buffer SplatTable { uvec4 splat_table[]; };
#endif
