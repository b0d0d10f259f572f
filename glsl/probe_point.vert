#version 460
// A point at a given place, of a given size. See src/gpu/probe/points.rs.
layout(std430, set = 0, binding = 0) readonly buffer Points { vec4 points[]; }; // place in NDC, size

void main() {
    vec4 point = points[gl_VertexIndex];
    gl_Position = vec4(point.xy, 0.5, 1.0);
    gl_PointSize = point.z;
}
