//! Drops placed by hand that reach into one another.

use crate::scene::Scene;

/// Most drops that are looked at: each with all that are as far to the left or right.
const MOST: usize = 10_000;

/// The numbers of two drops that intersect at the scene's time, and whether more do, in words; none if no two do. Spheres of
/// their volumes count; particles are not looked at.
pub(super) fn in_words(scene: &Scene) -> Option<String> {
    if scene.drops.len() > MOST {
        return None;
    }
    let mut spheres: Vec<_> = (1..)
        .zip(&scene.drops)
        .map(|(number, drop)| (drop.center_at(scene.time), drop.radius, number))
        .collect();
    spheres.sort_by(|(a, r, _), (b, s, _)| (a.x - r).total_cmp(&(b.x - s)));
    let mut met: Option<[u32; 2]> = None;
    for (at, (center, radius, number)) in spheres.iter().enumerate() {
        let beside = spheres[at + 1..].iter().take_while(|(c, r, _)| c.x - r < center.x + radius);
        for (other, other_radius, other_number) in beside {
            if center.distance(*other) >= radius + other_radius {
                continue;
            }
            if let Some([a, b]) = met {
                return Some(format!("{}, and others do", words(a, b)));
            }
            met = Some([*number, *other_number]);
        }
    }
    met.map(|[a, b]| words(a, b))
}

fn words(a: u32, b: u32) -> String {
    format!(
        "drops {} and {} intersect: which of them is in front is told for blocks of 4 x 2 pixels, of drops that move or \
         are out of focus for whole drops",
        a.min(b),
        a.max(b)
    )
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::PlacedDrop;

    #[test]
    fn drops_that_intersect_are_named() {
        let drop = |x: f64, y: f64| PlacedDrop::sphere(DVec3::new(x, y, -9.0), 1.0);
        let of = |drops: &[PlacedDrop], time: f64| {
            in_words(&Scene { drops: drops.to_vec(), rain: None, time, ..Scene::default() })
        };
        let mut drops = vec![drop(3.0, 0.0), drop(0.0, 0.0), drop(2.0, 0.0), drop(0.0, 2.1)];
        assert!(of(&drops[1..], 0.0).is_none(), "they touch at most");
        let said = of(&drops, 0.0).expect("two that intersect");
        assert!(said.starts_with("drops 1 and 3 intersect") && !said.contains("others"), "{said}");
        drops[3].velocity = DVec3::new(0.0, -1.0, 0.0);
        assert!(of(&drops[1..], 0.05).is_none());
        let said = of(&drops, 1.0).expect("more that do");
        assert!(said.ends_with(", and others do"), "{said}");
        // Far to the left, but wide.
        let wide = PlacedDrop { radius: 50.0, ..drop(-50.5, 0.0) };
        let said = of(&[drop(0.0, 0.0), drop(-9.0, 70.0), wide], 0.0).expect("a wide one");
        assert!(said.starts_with("drops 1 and 3"), "{said}");
    }
}
