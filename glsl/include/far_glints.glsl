// The two brightest images of sources in a far drop, and the light of all others.
struct FarGlints {
    vec4 first_at;  // on the drop, in radii from its centre, world space; w: red of the others' light
    vec4 first;     // light for a radius of a pixel; w: their green
    vec4 second_at; // w: their blue
    vec4 second;
};

// Radii that a place in the splats' table may be off the centre: farther than an outline reaches that is seen 75° off
// the axis of view. A step is 1/64.
const float LONGEST_OFFSET = 2.0;
