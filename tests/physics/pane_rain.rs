//! Rain on a pane: arrivals, merging, sliding and cover, against numbers that were computed elsewhere.

use glam::{DVec2, DVec3};
use raindrops::optics::Cap;
use raindrops::pane::Resting;
use raindrops::pane::arrivals::{Arrivals, Flux};
use raindrops::pane::keyframes::Keyframes;
use raindrops::pane::population::{Population, Surface};
use raindrops::pane::retention::{Retention, lean};
use raindrops::rain::law::{Law, marshall_palmer_slope};
use raindrops::scene::Scene;

fn close(found: f64, wanted: f64, part: f64, what: &str) {
    assert!((found / wanted - 1.0).abs() <= part, "{what}: {found} for {wanted}");
}

/// A pane at an angle from level that moves so fast towards -z, with its normal up and forward.
fn flux(law: Law, inclined: f64, speed: f64) -> Flux {
    let (sine, cosine) = inclined.to_radians().sin_cos();
    Flux::new(law, 1.2, DVec3::new(0.0, cosine, -sine), DVec3::new(0.0, 0.0, -speed))
}

fn marshall_palmer(rate: f64) -> Law {
    let law =
        Law { intercept: 1.0, mu: 0.0, slope: marshall_palmer_slope(rate), from: 0.25, to: 6.0 };
    law.normalised(rate, 1.2)
}

#[test]
fn as_much_arrives_as_the_pane_sweeps() {
    let law =
        Law { intercept: 8000.0, mu: 0.0, slope: marshall_palmer_slope(10.0), from: 0.25, to: 6.0 };
    let found = flux(law, 30.0, 20.0);
    close(found.number(), 2.050_609e4, 1e-4, "number");
    close(found.water(), 32.133_95, 1e-4, "water");
    close(found.cover(60.0), 0.026_901_0, 1e-4, "κ");
    // Rows of the table.
    for (rate, inclined, speed, number, water, cover) in [
        (1.0, 30.0, 14.0, 0.518, 2.73, 0.0035),
        (5.0, 0.0, 0.0, 0.262, 5.00, 0.0041),
        (25.0, 90.0, 14.0, 2.826, 59.1, 0.0437),
    ] {
        let found = flux(marshall_palmer(rate), inclined, speed);
        close(1e-4 * found.number(), number, 3e-3, "number");
        close(found.water(), water, 3e-3, "water");
        close(found.cover(60.0), cover, 2e-2, "κ");
    }
    // Nothing falls on a pane that moves away faster than rain comes.
    assert_eq!(flux(marshall_palmer(5.0), 90.0, -5.0).number(), 0.0);
    let slow = flux(marshall_palmer(5.0), 0.0, 0.0);
    let (normal, up) = (DVec3::Y, DVec3::new(0.0, -4.0, 0.0));
    let fast_alone = Flux::new(marshall_palmer(5.0), 1.2, normal, up);
    assert!(fast_alone.number() > 0.0 && fast_alone.number() < 0.3 * slow.number());
}

#[test]
fn arrivals_are_as_many_and_as_large_as_the_law_says() {
    let flux = flux(marshall_palmer(5.0), 30.0, 14.0);
    let (area, seconds) = (0.5, 20.0);
    let arrivals: Vec<_> =
        Arrivals::new(&flux, area, 3).take_while(|arrival| arrival.time <= seconds).collect();
    let expected = flux.number() * area * seconds;
    // Four standard deviations.
    assert!((arrivals.len() as f64 - expected).abs() < 4.0 * expected.sqrt(), "{}", arrivals.len());
    let water: f64 = arrivals.iter().map(|arrival| arrival.volume).sum();
    close(water / area / seconds * 3.6e6, flux.water(), 0.02, "water");
    let mean = arrivals.iter().map(|arrival| arrival.at).sum::<DVec2>() / expected;
    assert!((mean - 0.5).abs().max_element() < 0.01, "{mean}");
    let other: Vec<_> = Arrivals::new(&flux, area, 4).take(3).collect();
    assert_ne!(other[..], arrivals[..3]);
}

#[test]
fn a_drop_slides_when_it_is_heavier_than_its_rim_holds() {
    let vertical = Retention::new(1.0, [60.0, 30.0]);
    let volume = vertical.critical_volume(45.0);
    close(1e9 * volume, 15.3084, 1e-4, "volume");
    let cap = Cap::of_volume(volume, 45.0);
    close(1e3 * cap.radius, 2.8128, 1e-4, "radius");
    assert!(vertical.slides(1.001 * volume, Cap::of_volume(1.001 * volume, 45.0).radius));
    assert!(!vertical.slides(0.999 * volume, Cap::of_volume(0.999 * volume, 45.0).radius));
    for (angle, angles, slope, wanted) in [
        (35.0, [50.0, 20.0], 30_f64, 36.7),
        (35.0, [50.0, 20.0], 90.0, 13.0),
        (95.0, [105.0, 85.0], 60.0, 9.4),
    ] {
        let found = Retention::new(slope.to_radians().sin(), angles).critical_volume(angle);
        close(1e9 * found, wanted, 6e-3, "volume");
    }
    assert_eq!(Retention::new(0.0, [60.0, 30.0]).critical_volume(45.0), f64::INFINITY);
    let leaning = lean(&Cap { radius: 1e-3, angle: 60.0 }, 1.0);
    assert!((leaning - 2.85).abs() < 0.01, "{leaning}");
}

/// A pane of 0.1 x 0.1 m in rain, at contact angle θ.
fn pane(
    flux: &Flux,
    inclined: f64,
    angle: f64,
    angles: [f64; 2],
    trail: f64,
    seed: u64,
) -> Population {
    let surface = Surface {
        from: DVec2::splat(-0.05),
        to: DVec2::splat(0.05),
        angle,
        angle_spread: 0.0,
        retained: 1.0,
        trail,
        retention: Retention::new(inclined.to_radians().sin(), angles),
    };
    Population::new(surface, Arrivals::new(flux, 0.01, seed), &[])
}

fn volume(drops: &[Resting]) -> f64 {
    drops.iter().map(|drop| drop.volume).sum()
}

#[test]
fn drops_that_touch_become_one() {
    let surface = Surface {
        from: DVec2::splat(-0.05),
        to: DVec2::splat(0.05),
        angle: 60.0,
        angle_spread: 0.0,
        retained: 1.0,
        trail: 0.0,
        retention: Retention::new(0.0, [50.0, 20.0]),
    };
    let drop = |x: f64, radius: f64| {
        let volume = Cap { radius, angle: 60.0 }.volume();
        Resting { at: DVec2::new(x, 0.0), radius, angle: 60.0, volume }
    };
    let none = Arrivals::new(&flux(marshall_palmer(5.0), 90.0, -5.0), 0.01, 1);
    let settled = |drops: &[Resting]| Population::new(surface, none.clone(), drops).drops();
    let one = settled(&[drop(0.0, 2e-3), drop(2.5e-3, 1e-3)]);
    assert_eq!(one.len(), 1);
    close(one[0].radius, 2.080_084e-3, 1e-6, "radius");
    close(one[0].at.x, 0.277_778e-3, 1e-5, "centre");
    close(one[0].volume, 9.068_997e-9, 1e-6, "volume");
    assert_eq!(settled(&[drop(0.0, 2e-3), drop(3.01e-3, 1e-3)]).len(), 2);
    // One that joins two joins them all.
    assert_eq!(settled(&[drop(-1.2e-3, 1e-3), drop(1.2e-3, 1e-3), drop(0.0, 1e-3)]).len(), 1);
}

#[test]
fn water_is_neither_made_nor_lost() {
    for (inclined, angles, angle, trail) in [
        (30.0, [50.0, 20.0], 35.0, 0.0),
        (30.0, [50.0, 20.0], 35.0, 0.01),
        (90.0, [105.0, 85.0], 95.0, 0.02),
    ] {
        let flux = flux(marshall_palmer(25.0), inclined, 28.0);
        let mut rained = pane(&flux, inclined, angle, angles, trail, 7);
        for age in [2.0, 10.0, 40.0] {
            rained.go_on_to(age);
            let drops = rained.drops();
            let tally = rained.tally;
            close(volume(&drops) + tally.water_out, tally.water_in, 1e-9, "water");
            for drop in &drops {
                close(drop.volume, Cap { radius: drop.radius, angle }.volume(), 1e-9, "cap");
            }
            // None touches another, none should have slid.
            for (number, one) in drops.iter().enumerate() {
                for other in &drops[number + 1..] {
                    assert!(
                        one.at.distance(other.at) >= (one.radius + other.radius) * (1.0 - 1e-9)
                    );
                }
            }
        }
        assert!(rained.tally.water_out > 0.3 * rained.tally.water_in, "{:?}", rained.tally);
        // In parts or at once, again and to the bit.
        let mut again = pane(&flux, inclined, angle, angles, trail, 7);
        again.go_on_to(40.0);
        assert_eq!(again.drops(), rained.drops());
    }
}

/// More arrivals than states are kept of: 150,000, so that steps are made longer twice.
#[test]
fn a_pane_at_any_time_is_that_which_was_wiped_so_long_ago() {
    let flux = flux(marshall_palmer(25.0), 30.0, 28.0);
    let wiped = pane(&flux, 30.0, 35.0, [50.0, 20.0], 0.01, 7);
    let rate = 0.01 * flux.number();
    let step = 4096.0 / rate;
    let mut found = Keyframes::new(wiped.clone(), rate);
    // On, back, to a state that is kept, just before one, and beyond the last.
    for age in [
        1.5,
        0.5 * step,
        36.7 * step,
        3.0,
        16.0 * step,
        15.999 * step,
        0.0,
        5.0 * step,
        36.8 * step,
    ] {
        let mut expected = wiped.clone();
        expected.go_on_to(age);
        let found = found.at(age);
        assert_eq!((found.drops(), found.tally), (expected.drops(), expected.tally), "{age} s");
    }
    // Where no rain falls, nothing changes.
    let away = self::flux(marshall_palmer(5.0), 90.0, -5.0);
    let dry = pane(&away, 30.0, 35.0, [50.0, 20.0], 0.0, 7);
    assert!(Keyframes::new(dry, 0.0).at(1e9).drops().is_empty());
}

/// Mean cover of some seeds at some ages.
fn covers<const N: usize>(
    make: impl Fn(u64) -> Population,
    ages: [f64; N],
    seeds: u64,
) -> [f64; N] {
    let mut sums = [0.0; N];
    for seed in 0..seeds {
        let mut rained = make(seed);
        for (sum, age) in sums.iter_mut().zip(ages) {
            rained.go_on_to(age);
            *sum += rained.cover() / seeds as f64;
        }
    }
    sums
}

#[test]
fn a_clean_pane_is_covered_as_discs_at_random_would() {
    let flux = flux(marshall_palmer(5.0), 30.0, 14.0);
    let found = covers(|seed| pane(&flux, 30.0, 35.0, [50.0, 20.0], 0.0, seed), [5.0, 10.0], 20);
    let rate = flux.cover(35.0);
    // Merging takes more of it the more there is: 5 % at 10 s.
    for (found, (age, part)) in found.into_iter().zip([(5.0, 0.05), (10.0, 0.07)]) {
        close(found, 1.0 - (-rate * age).exp(), part, "cover");
    }
    // The table's row.
    close(rate, 0.0173, 0.01, "κ");
}

#[test]
fn cover_comes_to_a_balance() {
    let ordinary = [50.0, 20.0];
    for (rate, inclined, speed, angle, angles, trail, wanted) in [
        (25.0, 30.0, 28.0, 35.0, ordinary, 0.0, 0.26),
        (25.0, 30.0, 28.0, 35.0, ordinary, 0.01, 0.35),
        (25.0, 90.0, 5.0, 35.0, ordinary, 0.0, 0.16),
        (5.0, 90.0, 5.0, 35.0, ordinary, 0.0, 0.23),
        (5.0, 30.0, 14.0, 95.0, [105.0, 85.0], 0.0, 0.23),
    ] {
        let flux = flux(marshall_palmer(rate), inclined, speed);
        let ages = [120.0, 150.0, 180.0, 210.0, 240.0];
        let found = covers(|seed| pane(&flux, inclined, angle, angles, trail, seed), ages, 20);
        let mean = found.iter().sum::<f64>() / 5.0;
        close(mean, wanted, 0.15, "cover");
    }
}

#[test]
fn a_scene_has_the_same_drops_again_and_others_by_another_seed() {
    let text = |keys: &str| {
        format!(
            "metres = 0.5\n[pane]\npoint = [0, 0, -1]\nnormal = [0, 0.8, -0.6]\nrate = 5.0\nage = 6.0\nvelocity = [0, 0, -14]\n\
             extent = [0.2, 0.1]\n{keys}"
        )
    };
    let of = |keys: &str| Scene::parse(&text(keys), "a.toml").expect("a scene").pane_drops();
    let drops = of("");
    assert!(drops.len() > 500, "{}", drops.len());
    assert_eq!(drops, of("seed = 1"));
    assert_ne!(drops, of("seed = 2"));
    // In scene units of half a metre.
    assert!(drops.iter().all(|drop| drop.at.abs().x <= 0.2 && drop.at.abs().y <= 0.1));
    assert!(drops.iter().any(|drop| drop.at.abs().x > 0.15));
    let scattered = of("angle_spread = 10.0");
    let angles: Vec<f64> = scattered.iter().filter_map(|drop| drop.contact_angle).collect();
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    let spread = (angles.iter().map(|angle| (angle - mean).powi(2)).sum::<f64>()
        / angles.len() as f64)
        .sqrt();
    assert!((mean - 60.0).abs() < 2.0 && (7.0..11.0).contains(&spread), "{mean} {spread}");
    // A film's pane stays, or goes on with its time.
    let age = |keys: &str, number| {
        let scene = Scene::parse(&text(keys), "a.toml").expect("a scene");
        scene.film.frame(&scene, number).pane.expect("a pane").age()
    };
    assert_eq!((age("", 30), age("simulation = \"running\"", 30)), (6.0, 7.0));
    // What fell on it first stays where it is: drops of half the age are no other rain.
    let placed = of("[[pane.drop]]\nat = [0.0, 0.0]\nradius = 0.003");
    assert_ne!(placed, drops);
    // To the last digit, on any machine.
    let first: Vec<_> =
        of("seed = 9").iter().take(2).map(|drop| (drop.at.x, drop.radius)).collect();
    let wanted = [
        (-0.1960983455162808, 0.0020484070444454217),
        (-0.18700465266592803, 0.0004521057286716889),
    ];
    assert_eq!(first, wanted);
}
