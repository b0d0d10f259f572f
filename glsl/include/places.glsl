#ifndef PLACES_GLSL
#define PLACES_GLSL
// Where in a pixel its samples are: the Hammersley set, moved so that a single one is in the middle.
// Each of four has a row, a column and a quarter of its own; the sequence R2, whose first four lean to
// one corner, is off by twice as much.
vec2 place_of(uint number, uint count) {
    float inverse = float(bitfieldReverse(number)) * 2.3283064365386963e-10; // 2^-32
    return vec2((float(number) + 0.5) / float(count), inverse + 0.5 / float(count));
}

// By how much to move (modulo 1) the places of drop `index`: the sequence R2 of Roberts 2018, in integers.
vec2 place_moved(uint index) {
    return vec2(index * 3242174889u, index * 2447445413u) * 2.3283064365386963e-10;
}
#endif
