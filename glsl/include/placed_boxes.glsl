#ifndef PLACED_BOXES_GLSL
#define PLACED_BOXES_GLSL
// Placed drops as the frame's passes read them, and the box around some that share a cluster, while the shutter is open.
struct Placed {
    vec4 high; // centre in float32, radius
    vec3 low;  // what float32 lost of the centre
    uint number; // in layers
};

struct Box {
    vec3 low;
    vec3 high;
    float reach; // how far one of its drops reaches beyond its centre, at most; 0: it has none
};

const Box NO_BOX = Box(vec3(3e38), vec3(-3e38), 0.0);

// With a drop of a centre and a motion.
Box box_with(Box box, vec3 center, vec3 motion, float reach) {
    vec3 half_way = 0.5 * abs(motion);
    return Box(min(box.low, center - half_way), max(box.high, center + half_way), max(box.reach, reach));
}

// Its middle and half its edges, which are as much longer as float32 rounds.
Placed record_of_box(Box box) {
    vec3 rounded = 5e-7 * (abs(box.low) + abs(box.high));
    return Placed(vec4(0.5 * box.low + 0.5 * box.high, box.reach), 0.5 * box.high - 0.5 * box.low + rounded, 0u);
}
#endif
