#version 460
// What a texture unit makes of levels and places. See src/gpu/probe/sampling.rs.
layout(set = 0, binding = 0) uniform sampler2D levels; // every texel of a level holds its number
layout(set = 0, binding = 1) uniform sampler2D edge;   // two texels, 0 and 1
layout(push_constant) uniform Push { float scale; };   // of the implicit derivative
layout(location = 0) out vec4 found;

void main() {
    vec2 at = gl_FragCoord.xy;
    vec2 size = vec2(textureSize(levels, 0));
    float level = (at.x - 0.5) / 32.0 - 0.5;
    found.x = textureLod(levels, vec2(0.5), level).r;
    found.y = texture(levels, at * scale / size).r;
    found.z = textureLod(edge, vec2(0.25 + (at.x - 0.5) / 1024.0, 0.5), 0.0).r;
    found.w = 0.0;
}
