#ifndef BY_HAND_GLSL
#define BY_HAND_GLSL
// Which drops are placed by hand: those of the highest indices.
#include "frame.glsl"
#include "tile_buffers.glsl"

bool is_by_hand(uint index) {
    return HAS_PLACED != 0u && index >= frame.camera_place.w;
}

// Number of a drop among those that are.
uint by_hand_number(uint index) {
    return index - frame.camera_place.w;
}
#endif
