#ifndef SHAPE_GIVEN_GLSL
#define SHAPE_GIVEN_GLSL
// Which shape a drop has, and what follows for its outline.
#include "motion.glsl"
#include "shape.glsl"

// `Given` in src/passes/shapes.rs: diameter in mm of a drop of radius 1, which is the first's x, and what else is its head;
// the shapes of falling drops by diameter; those of drops placed by hand.
layout(std430, set = 1, binding = 5) readonly buffer Shapes { vec4 shapes[]; };
layout(set = 1, binding = 16) uniform usamplerBuffer shape_texels;

vec4 shape_at(uint number) {
    return BY_TEXELS != 0u ? uintBitsToFloat(texelFetch(shape_texels, int(number))) : shapes[number];
}

vec4 shape_of(uint index, Drop drop) {
    if (SHAPE == SPHERES) return ROUND;
    if (is_by_hand(index)) return shape_at(BY_HAND + by_hand_number(index));
    vec4 head = shape_at(0u);
    float at = (flattened_mm(drop, head.x) - float(SMALLEST_MM)) * float(DIAMETERS_A_MM);
    if (at < 0.0 || head.y == 0.0) return ROUND;
    uint below = min(uint(at), DIAMETERS - 2u);
    return mix(shape_at(BY_DIAMETER + below), shape_at(BY_DIAMETER + below + 1u), min(at - float(below), 1.0));
}

Outline outline_of_shape(Drop drop, vec4 shape) {
    ShapeOutline s = shape_outline_of(drop.view, drop.radius, shape);
    vec4 box = box_of(s);
    Outline o;
    o.center = s.upper.center + 0.5 * (box.xy + box.zw);
    o.box = 0.5 * (box.zw - box.xy);
    o.radius = sqrt(0.5 * (area_of(s.upper) + area_of(s.lower)) / 3.14159265);
    return o;
}

// What its outline is that of: two halves that move cover pixels, on the mean, as a spheroid of their width and height.
vec4 seen_as(vec4 shape, Path path) {
    if (path.moved == vec3(0.0)) return shape;
    float high = 0.5 * (shape.y + shape.z);
    return vec4(shape.x, high, high, shape.w + 0.5 * (shape.y - shape.z));
}

// May it be in view at any time, wherever within its reach it is?
bool may_show(Drop drop, Path path, vec4 shape, float distance2) {
    float reach = drop.radius * reach_of_shape(shape), unused, near = frame.camera_high.w;
    bool moves = is_exposed() && path.moved != vec3(0.0);
    uint what = moves ? visibility_moving(drop.view, path.moved, reach) : visibility(drop.view, reach, reach_across(drop.view, reach), unused);
    return what != OUT_OF_VIEW && distance2 >= near * near;
}
#endif
