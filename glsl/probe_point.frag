#version 460
// Where in the point a pixel is, and that it is in it. See src/gpu/probe/points.rs.
layout(location = 0) out vec4 mark;

void main() {
    mark = vec4(gl_PointCoord, 1.0, 0.0);
}
