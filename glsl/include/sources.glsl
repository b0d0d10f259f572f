#ifndef SOURCES_GLSL
#define SOURCES_GLSL
// The small bright sources that drops show apart (src/passes/glints.rs).

// Light of a source, as if all of it came from a disc of an even radiance.
struct Source {
    vec4 toward; // unit vector in world space; w: the disc's angular radius, radians
    vec4 light;  // radiance times solid angle, stored units
};

layout(std430, set = 0, binding = 14) readonly buffer Sources {
    uvec4 source_count; // x
    Source sources[];
};
#endif
