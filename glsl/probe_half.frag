#version 460
// Values for a float16 target, and what packHalf2x16 makes of them. See src/gpu/probe/halves.rs.
layout(constant_id = 0) const uint PACKED = 0;
layout(std430, set = 0, binding = 0) readonly buffer Values { float values[]; };
layout(push_constant) uniform Push { float alpha; float scale; };
layout(location = 0) out vec4 color;

void main() {
    float value = scale * values[uint(gl_FragCoord.x)];
    uint bits = packHalf2x16(vec2(value, 0.0)) & 0xffffu;
    color = PACKED != 0u ? vec4(bits, 0.0, 0.0, 0.0) : vec4(vec3(value), alpha);
}
