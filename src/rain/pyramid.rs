//! Which cells of real rain a picture looks into: layer by layer across the axis that is nearest to the view's, each a
//! rectangle around the section of the pyramid that the camera sees ([`Slab`]). So the work on the CPU grows with the
//! layers, some thousand, and not with the cells.

use glam::DVec3;

use crate::abi::Slab;
use crate::rain::cells::{Lattice, Place};
use crate::scene::Scene;
use crate::scene::projection::View;

/// What a camera sees: a pyramid with its tip in the camera.
pub(super) struct Pyramid {
    /// From the tip to the corners of its section at depth 1.
    corners: [DVec3; 4],
    /// The axis that is nearest to the view's.
    axis: usize,
    /// Radius of the lens in metres, and inverse distance of the focus.
    lens: [f64; 2],
}

impl Pyramid {
    /// That of a view of `scene`.
    pub(super) fn of(view: &View, scene: &Scene) -> Self {
        let [left, top, right, bottom] = view.tan_edges();
        let corner = |x: f64, y: f64| x * view.right + y * view.up - view.back;
        let steep = view.back.abs().to_array();
        Self {
            corners: [
                corner(-left, top),
                corner(right, top),
                corner(right, -bottom),
                corner(-left, -bottom),
            ],
            axis: (0..3).max_by(|a, b| steep[*a].total_cmp(&steep[*b])).unwrap_or(2),
            lens: match scene.drawn_lens() {
                0.0 => [0.0; 2],
                radius => [radius * scene.metres, (scene.camera.focus * scene.metres).recip()],
            },
        }
    }

    /// The layers of a lattice's cells whose drops may be in the pyramid, up to a depth in metres, while they move
    /// by `moved`. Class and group are left 0.
    pub(super) fn slabs(
        &self,
        lattice: &Lattice,
        reach: f64,
        camera: &Place,
        depth: f64,
        moved: DVec3,
    ) -> impl Iterator<Item = Slab> {
        let edge = lattice.edge();
        let tip = DVec3::ZERO;
        let far = self.corners.map(|corner| depth * corner);
        let mut edges: Vec<[DVec3; 2]> = far.iter().map(|corner| [tip, *corner]).collect();
        edges.extend((0..4).map(|i| [far[i], far[(i + 1) % 4]]));
        // Drops reach over their cell by so much; a little more, for rounding on the GPU.
        let [lens, inverse_focus] = self.lens;
        let apart = 1.001 * lens * (1.0 + (depth + reach) * inverse_focus);
        let reach = 1.001 * reach + 1e-5 * depth + apart;
        // Drops move by as much before the middle of the exposure as after it.
        let reach = reach + 0.5 * moved.abs();
        let fraction = DVec3::from_array(camera.fraction.map(f64::from)) / 4_294_967_296.0;
        let cell = move |metres: f64, axis: usize| (metres / edge + fraction[axis]).floor() as i32;

        let axis = self.axis;
        let ends = |f: fn(f64, f64) -> f64| far.iter().map(|p| p[axis]).fold(0.0, f);
        let (lowest, highest) = (ends(f64::min) - reach[axis], ends(f64::max) + reach[axis]);
        (cell(lowest, axis)..=cell(highest, axis)).filter_map(move |layer| {
            let from = (f64::from(layer) - fraction[axis]) * edge - reach[axis];
            let to = (f64::from(layer + 1) - fraction[axis]) * edge + reach[axis];
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for [a, b] in &edges {
                if let Some(part) = between(*a, *b, axis, from, to) {
                    for point in part {
                        (low, high) = (low.min(point), high.max(point));
                    }
                }
            }
            if low.x > high.x {
                return None;
            }
            let mut first = [0; 3];
            let mut counts = [1; 3];
            for along in 0..3 {
                let start = cell(low[along] - reach[along], along);
                first[along] = start;
                counts[along] = (cell(high[along] + reach[along], along) - start + 1) as u32;
            }
            (first[axis], counts[axis]) = (layer, 1);
            let [x, y, z] = counts;
            let cells = x.saturating_mul(y).saturating_mul(z);
            Some(Slab { first, kind: 0, across: [x, y], cells, first_group: 0 })
        })
    }
}

/// The ends of what of an edge lies between two planes across an axis.
fn between(a: DVec3, b: DVec3, axis: usize, from: f64, to: f64) -> Option<[DVec3; 2]> {
    let (low, high) = if a[axis] <= b[axis] { (a, b) } else { (b, a) };
    if low[axis] > to || high[axis] < from {
        return None;
    }
    let run = high[axis] - low[axis];
    let at = |height: f64| match run {
        0.0 => 0.0,
        _ => ((height - low[axis]) / run).clamp(0.0, 1.0),
    };
    Some([low.lerp(high, at(from)), low.lerp(high, at(to))])
}
