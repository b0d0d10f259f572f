#ifndef RADIANCE_SOURCE_GLSL
#define RADIANCE_SOURCE_GLSL
// The radiance that a display pass reads: an image, or a buffer of four halves a pixel, by texels where the device
// takes so many (on CPU drivers each word of a buffer is a read a lane). `width`: of the picture.
#ifdef RADIANCE_IN_TEXELS
layout(set = 0, binding = 1) uniform samplerBuffer radiance_texels;

vec4 pixel_at(uvec2 at, uint width) {
    return texelFetch(radiance_texels, int(at.y * width + at.x));
}
#elif defined(RADIANCE_IN_BUFFER)
layout(std430, set = 0, binding = 1) readonly buffer Radiance { uvec2 radiance_in[]; };

vec4 pixel_at(uvec2 at, uint width) {
    uvec2 word = radiance_in[at.y * width + at.x];
    return vec4(unpackHalf2x16(word.x), unpackHalf2x16(word.y));
}
#else
layout(set = 0, binding = 1) uniform sampler2D radiance_image;

vec4 pixel_at(uvec2 at, uint width) {
    return texelFetch(radiance_image, ivec2(at), 0);
}
#endif
#endif
