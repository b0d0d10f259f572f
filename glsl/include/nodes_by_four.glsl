#ifndef NODES_BY_FOUR_GLSL
#define NODES_BY_FOUR_GLSL
// The nodes of the tiles' lists, four words at a time: as texels where the device takes texel buffers so large. CPU
// drivers charge for each word that a lane reads from a storage buffer, and hardly more for the four of a texel than for
// one of those.
#include "tile_buffers.glsl"

#ifdef TEXELS
layout(set = 1, binding = 11) uniform usamplerBuffer node_texels;
uvec4 four_of_nodes(uint word) { return texelFetch(node_texels, int(word / 4u)); }
uint one_of_nodes(uint word) {
    uvec4 four = four_of_nodes(word);
    uvec2 pair = (word & 2u) == 0u ? four.xy : four.zw;
    return (word & 1u) == 0u ? pair.x : pair.y;
}
#else
uvec4 four_of_nodes(uint word) {
    return uvec4(nodes[word], nodes[word + 1u], nodes[word + 2u], nodes[word + 3u]);
}
uint one_of_nodes(uint word) { return nodes[word]; }
#endif
#endif
