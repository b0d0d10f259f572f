// Boxes by the number of a vertex, the last of them the sky around the eye: the scene of examples/host_ash.

struct Block {
    middle: vec4f, // w: 1 for the sky
    half_edges: vec4f,
    color: vec4f,
}
struct Frame {
    to_clip: mat4x4f,
    blocks: array<Block, 5>,
}
@group(0) @binding(0) var<uniform> frame: Frame;

struct Vertex {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) @interpolate(flat) number: u32,
}

const SUN = vec3f(0.5, 0.55, -0.67);

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> Vertex {
    var corners = array<vec2f, 6>(
        vec2f(-1.0, -1.0), vec2f(1.0, -1.0), vec2f(1.0, 1.0), vec2f(-1.0, -1.0), vec2f(1.0, 1.0), vec2f(-1.0, 1.0));
    let face = index / 6u;
    let at = corners[index % 6u];
    let side = select(-1.0, 1.0, face < 3u);
    let axis = face % 3u;
    var place = vec3f(at, side);
    var normal = vec3f(0.0, 0.0, side);
    if axis == 0u {
        place = vec3f(side, at);
        normal = vec3f(side, 0.0, 0.0);
    } else if axis == 1u {
        place = vec3f(at.x, side, at.y);
        normal = vec3f(0.0, side, 0.0);
    }
    let block = frame.blocks[number];
    let position = block.middle.xyz + block.half_edges.xyz * place;
    var clip = frame.to_clip * vec4f(position, 1.0);
    if block.middle.w != 0.0 { clip.z = 0.0; } // infinitely far
    return Vertex(clip, position, normal, number);
}

fn sky(d: vec3f) -> vec3f {
    if dot(d, normalize(SUN)) > 0.9997 { return vec3f(900.0); }
    if d.y < 0.0 { return vec3f(0.16, 0.15, 0.13) * (1.0 + 0.5 * d.y); }
    return mix(vec3f(0.85, 0.9, 1.0), vec3f(0.22, 0.42, 0.9), sqrt(d.y));
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4f {
    let block = frame.blocks[in.number];
    if block.middle.w != 0.0 { return vec4f(sky(normalize(in.position - block.middle.xyz)), 1.0); }
    var albedo = block.color.rgb;
    if block.half_edges.x > 10.0 { // the ground's tiles
        let tile = floor(in.position.xz);
        albedo *= select(0.7, 1.0, abs((tile.x + tile.y) % 2.0) < 0.5);
    }
    let around = mix(vec3f(0.12), vec3f(0.5, 0.6, 0.8), 0.5 + 0.5 * in.normal.y);
    return vec4f(albedo * (around + 0.9 * max(dot(in.normal, normalize(SUN)), 0.0)), 1.0);
}
