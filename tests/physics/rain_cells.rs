//! The rain's cells against the law that they stand for, and against themselves: from another camera, at
//! another time, far from the origin, across the borders of cells.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use raindrops::rain::cells::{CellDrop, DIAMETER_UNIT, Lattice, Place, lattices};
use raindrops::rain::classes::{Class, classes};
use raindrops::rain::field::{Field, Seen};
use raindrops::rain::law::{Law, marshall_palmer_slope};
use raindrops::rain::tick_of_seconds;
use raindrops::scene::Scene;

fn law(rate: f64) -> Law {
    let slope = marshall_palmer_slope(rate);
    Law { intercept: 1.0, mu: 0.0, slope, from: 0.25, to: 6.0 }.normalised(rate, 1.2)
}

fn rain(seed: u64, rate: f64) -> (Law, Vec<Class>, Vec<Lattice>) {
    let law = law(rate);
    let classes = classes(&law, 1.2);
    let lattices = lattices(seed, 0, &law, &classes, DVec3::new(2.0, 0.0, -1.0));
    (law, classes, lattices)
}

/// The drops of a cube of `cells` cells an edge from `start` on.
fn cube(lattice: &Lattice, start: i64, cells: i64) -> impl Iterator<Item = CellDrop> {
    let at = move |n: i64| start.wrapping_add(n);
    (0..cells.pow(3)).flat_map(move |n| {
        lattice.drops([at(n % cells), at(n / cells % cells), at(n / cells / cells)])
    })
}

/// Within four standard errors of a sum over Poisson drops.
fn within_four(what: &str, sum: f64, squares: f64, expected: f64) {
    let error = squares.sqrt();
    assert!((sum - expected).abs() < 4.0 * error, "{what}: {sum} ± {error}, expected {expected}");
}

#[test]
fn a_million_drops_keep_the_law() {
    let (law, classes, lattices) = rain(3, 25.0);
    assert_eq!(classes.len(), lattices.len());
    // Per cubic metre and class: drops, blocked area, water, water that falls; and their squares.
    let (mut sums, mut squares, mut drops) = ([0.0; 4], [0.0; 4], 0);
    let mut before = None;
    for (class, lattice) in classes.iter().zip(&lattices) {
        let volume = 1e6 / law.number();
        let cells = (volume.cbrt() / lattice.edge()).ceil();
        let volume = (cells * lattice.edge()).powi(3);
        for drop in cube(lattice, -17, cells as i64) {
            let d = drop.diameter_mm();
            let is = Some((drop.place.fraction, drop.diameter));
            assert!(is != before, "twice: {drop:?}");
            before = is;
            assert!(d > class.from - DIAMETER_UNIT && d < class.to + DIAMETER_UNIT);
            let of_drop = [1.0, d.powi(2), d.powi(3), class.speed * d.powi(3)];
            for (i, value) in of_drop.into_iter().enumerate() {
                sums[i] += value / volume;
                squares[i] += (value / volume).powi(2);
            }
            drops += 1;
        }
    }
    assert!(drops > 1_000_000, "{drops}");
    within_four("number", sums[0], squares[0], law.moment(0.0));
    within_four("extinction", sums[1], squares[1], law.moment(2.0));
    within_four("water", sums[2], squares[2], law.moment(3.0));
    within_four("rate", sums[3], squares[3], law.water_flux(law.from, law.to));
    // The control: as many drops of a rain of 24 mm/h are told apart.
    assert!((sums[2] - self::law(24.0).moment(3.0)).abs() > 4.0 * squares[2].sqrt());
}

/// Means over the tables themselves, without a random number.
#[test]
fn the_tables_keep_the_law() {
    for rate in [0.1, 25.0, 2000.0] {
        let (law, classes, lattices) = rain(1, rate);
        let mut sums = [0.0; 5];
        for (class, lattice) in classes.iter().zip(&lattices) {
            let reached = lattice.thresholds.iter().map(|t| 1.0 - f64::from(*t) / 2.0_f64.powi(32));
            let number = reached.sum::<f64>() / lattice.edge().powi(3);
            assert!((number / class.number - 1.0).abs() < 1e-6, "{number} {}", class.number);
            for (k, sum) in (0..).zip(&mut sums) {
                for pair in lattice.quantiles.windows(2) {
                    let [a, b] = [pair[0], pair[1]].map(|d| f64::from(d) * DIAMETER_UNIT);
                    let mean = (b.powi(k + 1) - a.powi(k + 1)) / (f64::from(k + 1) * (b - a));
                    *sum += number * mean / 64.0;
                }
            }
        }
        for (k, sum) in (0..).zip(sums) {
            let expected = law.moment(f64::from(k));
            let worst = [1e-6, 1e-5, 2e-5, 1e-4, 3e-4][k as usize];
            assert!((sum / expected - 1.0).abs() < worst, "{rate} {k}: {sum} {expected}");
        }
    }
}

/// The drops within `reach` metres of a camera on each axis: which they are, and where in the world.
fn seen(
    lattice: &Lattice,
    camera: DVec3,
    seconds: f64,
    reach: f64,
) -> BTreeMap<([i64; 3], u32), (CellDrop, DVec3)> {
    let place = lattice.place(camera, tick_of_seconds(seconds));
    let mut found = BTreeMap::new();
    let inside = |low: DVec3, high: DVec3| low.max(-high).max_element() <= reach;
    lattice.visit(&place, reach, DVec3::ZERO, &inside, &mut |cell| {
        for drop in lattice.drops(cell) {
            let relative = lattice.between(&place, &drop.place);
            if relative.abs().max_element() < reach {
                found.insert((cell, drop.number), (drop, camera + relative));
            }
        }
    });
    found
}

#[test]
fn two_cameras_see_the_same_drops_where_both_look() {
    let (_, _, lattices) = rain(9, 100.0);
    for lattice in [&lattices[0], &lattices[13], &lattices[30]] {
        let reach = 6.0 * lattice.edge();
        let second = DVec3::new(0.4, -0.3, 0.7) * reach;
        for seconds in [0.0, 3600.0, -12.5] {
            let of_first = seen(lattice, DVec3::ZERO, seconds, reach);
            let of_second = seen(lattice, second, seconds, reach);
            let shared = |world: DVec3| {
                // Off the borders by more than a rounding.
                world.abs().max((world - second).abs()).max_element() < reach - 1e-5
            };
            let mut count = 0;
            for (which, (drop, world)) in of_first.iter().filter(|(_, (_, at))| shared(*at)) {
                let (same, there) = &of_second[which];
                assert_eq!(drop, same);
                assert!(world.distance(*there) < lattice.edge() / 2.0_f64.powi(30));
                count += 1;
            }
            assert_eq!(count, of_second.values().filter(|(_, at)| shared(*at)).count());
            assert!(count > 300, "{count}");
        }
    }
}

#[test]
fn drops_fall_with_their_class_and_come_back() {
    let (_, _, lattices) = rain(9, 25.0);
    let (step, camera) = (1.0 / 64.0, DVec3::new(0.3, 1.7, -2.0));
    for lattice in &lattices {
        let drop = Place { cell: [0; 3], fraction: [1 << 31; 3] };
        let at = |seconds: f64| lattice.place(camera, tick_of_seconds(seconds));
        for start in [0.0, 5.0, -1e5, 1e9] {
            let before = lattice.between(&at(start), &drop);
            let after = lattice.between(&at(start + step), &drop);
            let moved = after - before - lattice.velocity * step;
            // A cell is 2^32 steps; at 10⁹ s there are 53 bits of a double in `before`.
            let steps = 4.0 * lattice.edge() / 4_294_967_296.0 + 1e-15 * before.abs().max_element();
            assert!(moved.abs().max_element() < steps, "{moved} in {step} s from {start} s");
        }
        // Motion is a product of integers: forwards and backwards alike, to the last bit.
        for seconds in [1e-6, 0.25, 1e6, 3e12] {
            let along = |seconds: f64, axis: usize| {
                let Place { cell, fraction } = at(seconds);
                (i128::from(cell[axis]) << 32) + i128::from(fraction[axis])
            };
            for axis in 0..3 {
                let there = along(seconds, axis) - along(0.0, axis);
                let back = along(-seconds, axis) - along(0.0, axis);
                // Rounded down both ways.
                assert!((0..=1).contains(&(there + back).abs()), "{there} {back}");
            }
        }
    }
}

#[test]
fn far_from_the_origin_the_rain_is_as_good() {
    let (law, classes, lattices) = rain(4, 25.0);
    let far = DVec3::new(1e9, -1e9, 123_456_789.0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for lattice in &lattices {
        let place = lattice.place(far, tick_of_seconds(1e7));
        let volume = (32.0 * lattice.edge()).powi(3);
        for drop in cube(lattice, place.cell[0], 32) {
            sum += drop.diameter_mm().powi(2) / volume;
            squares += (drop.diameter_mm().powi(2) / volume).powi(2);
        }
        // A step of the camera moves the drops by that step, to 2⁻³² of a cell.
        let step = DVec3::new(0.5, -0.25, 0.125);
        let moved = lattice.between(&place, &lattice.place(far + step, tick_of_seconds(1e7)));
        assert!((moved - step).abs().max_element() < lattice.edge() / 2.0_f64.powi(31), "{moved}");
    }
    assert_eq!(classes.len(), lattices.len());
    within_four("extinction", sum, squares, law.moment(2.0));
    // High words of a cell's number matter: 2^32 cells away there are other drops.
    let cell = |x: i64| lattices[5].drops([x, 7, -3]).map(|drop| drop.place.fraction[0]);
    let count: usize = (0..100).map(|x| cell(x).count()).sum();
    let same = (0..100).flat_map(|x| cell(x).filter(move |p| cell(x + (1 << 32)).any(|q| q == *p)));
    assert!(count > 100 && same.count() == 0);
}

/// Chi-square of counts against an equal expectation, in standard deviations of its own.
fn excess(counts: &[f64], expected: f64) -> f64 {
    let chi: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
    let freedom = counts.len() as f64;
    (chi - freedom) / (2.0 * freedom).sqrt()
}

/// If places in a cell, in neighbouring cells or in neighbouring classes depended on one another, or cells
/// showed, one of these counts would be off. Each is a chi-square of some hundred thousand drops.
#[test]
fn cells_leave_no_trace() {
    let (_, _, lattices) = rain(7, 25.0);
    let (lattice, other) = (&lattices[3], &lattices[4]);
    let cells: i64 = 64;
    let bin = |fraction: u32| (fraction >> 28) as usize;
    let (mut within, mut beside, mut classes) =
        (vec![0.0; 4096], vec![vec![0.0; 256]; 3], vec![0.0; 256]);
    let mut drops = 0.0;
    // Counts in boxes of a cell's size that lie half a cell off.
    let mut boxes = vec![0.0_f64; cells.pow(3) as usize];
    for n in 0..cells.pow(3) {
        let cell = [n % cells, n / cells % cells, n / cells / cells];
        let first = |lattice: &Lattice, cell| lattice.drops(cell).next();
        for drop in lattice.drops(cell) {
            let [x, y, z] = drop.place.fraction.map(bin);
            within[x << 8 | y << 4 | z] += 1.0;
            drops += 1.0;
            let half = |axis: usize| {
                (cell[axis] + i64::from(drop.place.fraction[axis] >> 31)).rem_euclid(cells)
            };
            boxes[(half(0) + cells * (half(1) + cells * half(2))) as usize] += 1.0;
        }
        let Some(here) = first(lattice, cell) else { continue };
        for (axis, counts) in beside.iter_mut().enumerate() {
            let mut next = cell;
            next[axis] += 1;
            if let Some(there) = first(lattice, next) {
                counts[bin(here.place.fraction[axis]) << 4 | bin(there.place.fraction[axis])] +=
                    1.0;
            }
        }
        if let Some(there) = first(other, cell) {
            classes[bin(here.place.fraction[0]) << 4 | bin(there.place.fraction[0])] += 1.0;
        }
    }
    assert!(excess(&within, drops / 4096.0).abs() < 5.0);
    for counts in beside.iter().chain([&classes]) {
        let pairs: f64 = counts.iter().sum();
        assert!(pairs > 100_000.0 && excess(counts, pairs / 256.0).abs() < 5.0);
    }
    // A Poisson count's variance is its mean, whichever way the boxes lie.
    let mean = drops / boxes.len() as f64;
    let variance =
        boxes.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / boxes.len() as f64;
    let error = (2.0 + 1.0 / mean).sqrt() / (boxes.len() as f64).sqrt();
    assert!((variance / mean - 1.0).abs() < 5.0 * error, "{}", variance / mean);
}

/// A shader without 64-bit integers finds the same cell and the same diameter.
#[test]
fn two_words_and_a_carry_do() {
    let (_, _, lattices) = rain(2, 25.0);
    let lattice = &lattices[8];
    for (cell, offset) in [(5_i64, -7_i32), (-1, 1), ((1 << 32) - 1, 3), (i64::MIN, -1)] {
        let (low, high) = (cell as u32, (cell >> 32) as u32);
        let sum = low.wrapping_add(offset as u32);
        let carry = u32::from(sum < low);
        let high = high.wrapping_add((offset >> 31) as u32).wrapping_add(carry);
        let expected = cell.wrapping_add(i64::from(offset));
        assert_eq!((sum, high), (expected as u32, (expected >> 32) as u32));
    }
    let in_float32 = |drop: &CellDrop| f64::from(drop.diameter as f32) == f64::from(drop.diameter);
    assert!(cube(lattice, 0, 20).all(|drop| in_float32(&drop)));
}

/// Every cell that a region meets is visited, once.
#[test]
fn a_visit_misses_no_cell() {
    let (_, _, lattices) = rain(2, 25.0);
    let lattice = &lattices[20];
    let camera = lattice.place(DVec3::new(0.1, 5.0, -3.0), tick_of_seconds(0.3));
    let (center, radius) = (DVec3::new(1.0, -0.5, 2.0), 4.0 * lattice.edge());
    let meets = |low: DVec3, high: DVec3| center.distance(center.clamp(low, high)) < radius;
    let mut visited = Vec::new();
    lattice
        .visit(&camera, 9.0 * lattice.edge(), DVec3::ZERO, &meets, &mut |cell| visited.push(cell));
    let unique: BTreeSet<_> = visited.iter().copied().collect();
    assert_eq!(unique.len(), visited.len());
    let mut inside = 0;
    for n in 0..40_i64.pow(3) {
        let cell = [n % 40, n / 40 % 40, n / 1600];
        let cell = [0, 1, 2].map(|axis| camera.cell[axis] + cell[axis] - 20);
        for drop in lattice.drops(cell) {
            if lattice.between(&camera, &drop.place).distance(center) < radius {
                inside += 1;
                assert!(unique.contains(&cell));
            }
        }
    }
    assert!(inside > 100);
}

/// What a film's frames have in common is kept between them: of another zoom, cut-off, shutter or shape of drops nothing stays.
#[test]
fn rain_that_was_seen_before_is_that_seen_anew() {
    let of = |camera: &str| {
        let text = format!("[rain]\nrate = 25.0\n[camera]\n{camera}\n");
        Scene::parse(&text, "test").expect("a scene")
    };
    let cameras =
        ["vertical_fov = 60.0", "vertical_fov = 60.0\nshutter = 0.01", "vertical_fov = 20.0"]
            .map(of);
    let made = |scene: &Scene, is_flattened: bool, px: f64| {
        let field = Field::of(scene).expect("rain").flattened(is_flattened);
        field.grainy(true).thinned(scene, px)
    };
    let told = |seen: &Seen| (seen.medium, seen.grain, seen.band_depths);
    let mut field = made(&cameras[0], false, 0.2);
    let mut pictures = Vec::new();
    // In turn each of these alone is another.
    for (camera, is_flattened, thinned_px, cutoff_px) in [
        (0, false, 0.2, 0.1),
        (1, false, 0.2, 0.1),
        (1, true, 0.2, 0.1),
        (1, true, 0.1, 0.1),
        (1, true, 0.1, 0.2),
        (2, true, 0.1, 0.2),
        (2, true, 0.0, 0.2),
        (2, true, 0.0, 0.0),
    ] {
        let scene = &cameras[camera];
        field = field.flattened(is_flattened).thinned(scene, thinned_px);
        let seen = told(&field.seen(scene, cutoff_px));
        assert_eq!(seen, told(&field.seen(scene, cutoff_px)), "again");
        let anew = made(scene, is_flattened, thinned_px).seen(scene, cutoff_px);
        assert_eq!(seen, told(&anew), "{thinned_px} {cutoff_px} {:?}", scene.camera);
        pictures.push(seen);
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 8, "some are equal");
}
