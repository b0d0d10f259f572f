#ifndef BY_TEXELS_GLSL
#define BY_TEXELS_GLSL
// CPU drivers read each word of a storage buffer lane by lane, and four words of a texel for hardly more than one. So what a
// pass only reads, and does not find by an address that is constant, it reads by texels. 1 on every device that takes texel
// buffers of so many, GPUs among them.
layout(constant_id = 30) const uint BY_TEXELS = 0;
#endif
