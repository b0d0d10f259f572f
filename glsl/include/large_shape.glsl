#ifndef LARGE_SHAPE_GLSL
#define LARGE_SHAPE_GLSL
// What large drops that are no spheres have beside `Large`.
struct LargeShape {
    vec4 shape;         // see shape.glsl
    vec4 lower_to_disc; // of the lower half's ellipse, as `to_disc` of the upper's
    vec2 lower;         // its centre from the upper's, pixels
    vec2 gradient;      // of what parts the halves on the screen: negative where the upper's outline holds
    vec4 box;           // around the outline: left, top, right, bottom from the upper ellipse's centre, pixels
    float at_upper;     // what parts them at the upper's centre
    float radius;       // of a disc of the outline's area, pixels
    uint upright;       // see flattened.glsl
    uint unused;
    uvec4 lightened;
};

// An outline, as `to_disc`, that holds every pixel: where such a drop is its rays tell.
const vec4 EVERYWHERE = vec4(1e-6, 0.0, 0.0, 1e-6);

// A drop whose outline is no ellipse may be anywhere.
LargeShape no_outline(vec4 shape) {
    return LargeShape(shape, EVERYWHERE, vec2(0.0), vec2(0.0), vec4(-1e6, -1e6, 1e6, 1e6), -1.0, 1e6, 0u, 0u, uvec4(0u));
}

bool has_outline(LargeShape l) {
    return l.radius < 1e6;
}
#endif
