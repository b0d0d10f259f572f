#ifndef PAIRS_GLSL
#define PAIRS_GLSL
// Numbers as sums of two float32, of which the second is at most half a unit in the last place of the first (double-float
// arithmetic, Dekker 1971): 48 bits, by operations that all devices round alike. The same as src/rain/pairs.rs, bit for bit.
struct Pair {
    vec3 high;
    vec3 low;
};

// The sum of two, of which the first is larger, or 0.
Pair pair_of_sum(vec3 large, vec3 small) {
    precise vec3 high = large + small, low = small - (high - large);
    return Pair(high, low);
}

Pair add_pairs(Pair a, Pair b) {
    // Knuth's sum of two, which loses nothing.
    precise vec3 sum = a.high + b.high, added = sum - a.high;
    precise vec3 lost = (a.high - (sum - added)) + (b.high - added);
    precise vec3 low = lost + (a.low + b.low);
    return pair_of_sum(sum, low);
}

// The first twelve bits of each.
vec3 first_bits(vec3 v) {
    return uintBitsToFloat(floatBitsToUint(v) & 0xfffff000u);
}

// Times a number, a pair as well.
Pair scale_pair(Pair a, vec2 factor) {
    vec3 first = first_bits(a.high), of_factor = first_bits(vec3(factor.x));
    precise vec3 product = a.high * factor.x, rest = a.high - first, rest_of_factor = factor.x - of_factor;
    precise vec3 lost = ((first * of_factor - product) + first * rest_of_factor + rest * of_factor) + rest * rest_of_factor;
    precise vec3 low = lost + (a.high * factor.y + a.low * factor.x);
    return pair_of_sum(product, low);
}
#endif
