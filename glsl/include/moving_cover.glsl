// How much a drop with an outline that moves evenly covers of a row of pixels, on the mean, and where in its picture the
// row's colours stand meanwhile. Needs tile_buffers.glsl, streak.glsl; `cover` for a drop at rest.

// Of a longer way an outline's mean is found along its chords, of a shorter one by four of its places.
const float STEPS_PX = 4.0;
const uint STEPS = 4;

// Twice the integral of a unit disc's half chords.
vec4 chords_to(vec4 m) {
    return m * sqrt(max(1.0 - m * m, 0.0)) + asin(m);
}

// By chords: part of the time for which the pixels' part within the way's width is covered. `radius`: its mean, pixels.
vec4 cover_by_chords(vec2 from, vec4 to_disc, vec2 way, float radius) {
    vec4 x = from.x + vec4(0.0, 1.0, 2.0, 3.0);
    vec4 s = to_disc.x * x + to_disc.z * from.y, t = to_disc.y * x + to_disc.w * from.y;
    vec2 moved = vec2(to_disc.x * way.x + to_disc.z * way.y, to_disc.y * way.x + to_disc.w * way.y);
    float length = length(moved), pixel = 1.0 / radius;
    vec2 n = moved / length;
    vec4 along = s * n.x + t * n.y, across = s * n.y - t * n.x;
    vec4 low = clamp(across - 0.5 * pixel, -1.0, 1.0), high = clamp(across + 0.5 * pixel, -1.0, 1.0);
    vec4 width = high - low, chord = (chords_to(high) - chords_to(low)) / max(width, 1e-6);
    // The pixel's own length goes with the shorter of chord and way.
    bvec4 shorter = lessThan(chord, vec4(length));
    vec4 wider = sqrt(chord * chord + pixel * pixel);
    vec4 first = mix(chord, wider, shorter);
    vec4 second = mix(vec4(sqrt(length * length + pixel * pixel)), vec4(length), shorter);
    vec4 overlap = clamp(0.5 * (first + second) - abs(along), vec4(0.0), min(first, second));
    return width / pixel * overlap / second * mix(vec4(1.0), chord / wider, shorter);
}

// Where the pixel at (s, t) of the disc is on it at a part of the time that it covers the pixel.
vec2 place_on_disc(vec2 at, vec2 moved, float part) {
    float length2 = max(dot(moved, moved), 1e-12), middle = dot(at, moved) / length2;
    float across = (at.x * moved.y - at.y * moved.x) * inversesqrt(length2);
    float reach = sqrt(max(1.0 - across * across, 0.0) / length2);
    float from = clamp(middle - reach, -0.5, 0.5), to = clamp(middle + reach, -0.5, 0.5);
    return at - moved * mix(from, to, part);
}
