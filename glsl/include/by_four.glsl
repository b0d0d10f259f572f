// What composite.comp reads, as texels, most of four words (nodes_by_four.glsl). Needs tile_buffers.glsl, `sky` and
// `splat_table`.
#define NODES_BINDING 25
#include "nodes_by_four.glsl"
#ifdef TEXELS
layout(set = 0, binding = 26) uniform usamplerBuffer sky_texels;
layout(set = 0, binding = 27) uniform usamplerBuffer splat_texels;
uvec4 two_of_sky(uint pixel) { return texelFetch(sky_texels, int(pixel / 2u)); }
uvec4 splat_of(uint direction, uint part) { return texelFetch(splat_texels, int(2u * direction + part)); }
#else
uvec4 two_of_sky(uint pixel) { return uvec4(sky[pixel], sky[pixel + 1u]); }
uvec4 splat_of(uint direction, uint part) { return splat_table[2u * direction + part]; }
#endif
