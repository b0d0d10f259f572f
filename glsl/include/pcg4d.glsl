#ifndef PCG4D_GLSL
#define PCG4D_GLSL
// The hash of Jarzynski and Olano 2020: four well-mixed numbers from four; the same as `pcg4d` in src/rain/mod.rs.
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}
#endif
