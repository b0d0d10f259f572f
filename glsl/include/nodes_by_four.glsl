#ifndef NODES_BY_FOUR_GLSL
#define NODES_BY_FOUR_GLSL
// The nodes of the tiles' lists, four words at a time.
#include "tile_buffers.glsl"

layout(set = 1, binding = 11) uniform usamplerBuffer node_texels;

uvec4 four_of_nodes(uint word) {
    if (BY_TEXELS != 0u) return texelFetch(node_texels, int(word / 4u));
    return uvec4(nodes[word], nodes[word + 1u], nodes[word + 2u], nodes[word + 3u]);
}

uint one_of_nodes(uint word) {
    if (BY_TEXELS == 0u) return nodes[word];
    uvec4 four = four_of_nodes(word);
    uvec2 pair = (word & 2u) == 0u ? four.xy : four.zw;
    return (word & 1u) == 0u ? pair.x : pair.y;
}
#endif
