#ifndef DISC_COVER_GLSL
#define DISC_COVER_GLSL
// The exact part of a pixel's square that a disc or an ellipse covers. At the rim a drop may be a hundred times as bright as
// what is around it: a part of 0.005, which a ramp across the edge leaves out, is seen.

// Angle between two vectors, signed. The series is for small angles, of which a driver's `atan` has too few digits: the
// angles of a pixel's sides are summed and nearly cancel.
float angle_from_to(vec2 a, vec2 b) {
    float along = dot(a, b), x = (a.x * b.y - a.y * b.x) * inversesqrt(max(dot(a, a) * dot(b, b), 1e-30)), x2 = x * x;
    if (along < 0.0 || x2 > 0.25) return atan(a.x * b.y - a.y * b.x, along);
    return x * (1.0 + x2 * (0.16666667 + x2 * (0.075 + x2 * (0.044642857 + x2 * 0.030381944))));
}

// Signed area of the unit disc within the triangle of its middle and two points.
float disc_in_triangle(vec2 a, vec2 b) {
    vec2 way = b - a;
    float squared = dot(way, way), nearest = -dot(a, way) / squared;
    vec2 to_line = a + nearest * way;
    float half_chord2 = (1.0 - dot(to_line, to_line)) / squared;
    float reach = sqrt(max(half_chord2, 0.0)), enters = nearest - reach, leaves = nearest + reach;
    if (half_chord2 <= 0.0 || leaves <= 0.0 || enters >= 1.0) return 0.5 * angle_from_to(a, b);
    vec2 first = a + max(enters, 0.0) * way, last = a + min(leaves, 1.0) * way;
    float area = 0.5 * (first.x * last.y - first.y * last.x);
    if (enters > 0.0) area += 0.5 * angle_from_to(a, first);
    if (leaves < 1.0) area += 0.5 * angle_from_to(last, b);
    return area;
}

// Less than this is rounding: the pixel beside an outline that touches it.
const float LEAST_AREA = 1e-4;

// The part of the pixel's square about `at` that is covered by what `to_disc` takes to the unit disc.
float disc_cover(vec2 at, vec4 to_disc) {
    mat2 m = mat2(to_disc.xy, to_disc.zw);
    vec2 middle = m * at, right = 0.5 * m[0], down = 0.5 * m[1];
    vec2 a = middle - right - down, b = middle + right - down, c = middle + right + down, d = middle - right + down;
    float area = disc_in_triangle(a, b) + disc_in_triangle(b, c) + disc_in_triangle(c, d) + disc_in_triangle(d, a);
    float covered = min(area / determinant(m), 1.0);
    return covered < LEAST_AREA ? 0.0 : covered;
}
#endif
