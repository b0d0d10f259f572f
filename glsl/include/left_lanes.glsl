#ifndef LEFT_LANES_GLSL
#define LEFT_LANES_GLSL
// 1: lanes that leave a loop at its end, while others go on, lose what they have read last (src/gpu/promises.rs). A loop of
// which something is read afterwards then needs a way out at its beginning that no lane takes, and no compiler rules out.
layout(constant_id = 32) const uint LOSES_LEFT = 0;
#endif
