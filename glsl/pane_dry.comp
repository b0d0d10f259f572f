#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
// The picture through the dry pane, one invocation a pixel; and which pixels drops touch. See src/passes/pane.rs.
#include "pane.glsl"
#include "pane_drops.glsl"
#include "pane_pictures.glsl"
#include "together.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

const uint TOUCHED_GROUP = 64; // pixels of a workgroup of pane_rays.comp
const uint GROUPS_A_ROW = 32768; // of those

// Rays of a pixel leave the glass within `around` of a place. The edges of a pixel and the lens are told by their
// derivatives, a little enlarged for what these leave out.
struct Footprint {
    vec2 place, slope;
    float around;
};

Footprint footprint_of(vec2 pixel) {
    PaneRay middle = pane_ray(pixel, vec2(0.0), 0.5);
    Footprint f;
    f.place = wet_place(middle);
    f.slope = middle.direction.xy / middle.direction.z;
    vec2 right = wet_place(pane_ray(pixel + vec2(0.5, 0.0), vec2(0.0), 0.5)) - f.place;
    vec2 down = wet_place(pane_ray(pixel + vec2(0.0, 0.5), vec2(0.0), 0.5)) - f.place;
    vec2 lens_right = wet_place(pane_ray(pixel, vec2(1.0, 0.0), 0.5)) - f.place;
    vec2 lens_up = wet_place(pane_ray(pixel, vec2(0.0, 1.0), 0.5)) - f.place;
    float lens = sqrt(dot(lens_right, lens_right) + dot(lens_up, lens_up));
    f.around = 1.2 * (length(right) + length(down) + lens) + length(pane.motion);
    return f;
}

// Whether a drop may touch the pixel: of those in the cells around it.
bool is_touched(Footprint f) {
    vec2 way = length(f.slope) * inversesqrt(1.0 + dot(f.slope, f.slope)) > pane.overhang ? pane.tallest * f.slope : vec2(0.0);
    vec2 low = min(f.place, f.place + way) - f.around, high = max(f.place, f.place + way) + f.around;
    vec2 end = pane.cell * vec2(pane.cells);
    bool found = false;
    if (any(lessThan(high, vec2(0.0))) || any(greaterThan(low, end))) return false;
    uvec2 first = cell_of(low), last = cell_of(high);
    for (uint y = first.y; y <= last.y && !found; ++y) {
        // A row's cells are one after the other.
        uint from = caps_of(uvec2(first.x, y)).x, to = caps_of(uvec2(last.x, y)).y;
        for (uint i = from; i < to && !found; ++i) found = may_touch(cap_at(cell_word(i)), f.place, f.slope, f.around);
    }
    return found;
}

// Notes the pixels that drops touch.
void note(bool is_noted, uint pixel) {
    uvec4 noted = subgroupBallot(is_noted);
    uint count = subgroupBallotBitCount(noted), before = subgroupBallotExclusiveBitCount(noted), at = 0u;
    bool leads = subgroupElect();
    TAKE_TOGETHER(touched_count, count, leads, at);
    if (leads && count > 0u) {
        uint groups = (at + count + TOUCHED_GROUP - 1u) / TOUCHED_GROUP;
        atomicMax(touched_groups.x, min(groups, GROUPS_A_ROW));
        atomicMax(touched_groups.y, (groups + GROUPS_A_ROW - 1u) / GROUPS_A_ROW);
    }
    if (is_noted) touched[at + before] = pixel;
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy, size = frame.window.zw;
    bool is_drawn = all(lessThan(at, size));
    uint number = min(at.y, size.y - 1u) * size.x + min(at.x, size.x - 1u);
    vec2 pixel = vec2(frame.window.xy + at) + 0.5;
    PaneRay ray = pane_ray(pixel, vec2(0.0), 0.5);
    // A pixel of whose rays some may not meet the pane is drawn by rays.
    bool meets = ray.direction.z > 0.0, is_edge = abs(ray.direction.z) < 2.0 / frame.image.z + frame.lens.x * frame.lens.y;
    bool touched = is_drawn && (is_edge || meets && is_touched(footprint_of(pixel)));
    float through = meets ? dry_pane(ray.direction.z) : 1.0;
    if (is_drawn) radiance_out[number] = before_picture(number, (1.0 - through) * pane.inside, through);
    if (is_drawn && PANE_NEAREST != 0u) nearest_caps[number] = uvec2(NO_CAP, 0u);
    note(touched, number);
}
