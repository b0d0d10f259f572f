//! The rain's laws against published figures, and against sums over fine steps of the diameter that share no
//! code with them.

use std::f64::consts::PI;

use raindrops::rain::classes::{CLASSES, classes};
use raindrops::rain::fall::{density_factor, terminal_speed};
use raindrops::rain::law::{Law, marshall_palmer_slope};
use raindrops::rain::medium::{
    cutoff_of_budget, optical_depth, starts, unseen_radius, visibility as visibility_of,
};
use raindrops::rain::thinned::{Reach, drops_drawn};
use raindrops::rain::visibility::{Frustum, depth_of_radius, radius_px, streak_px, streak_share};
use raindrops::scene::model::Sizes;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{RainSettings, Scene};

/// Within a relative tolerance.
fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value / expected - 1.0).abs() <= tolerance, "{value}, expected {expected}");
}

/// Marshall and Palmer's law with its own N0.
fn marshall_palmer(rate: f64, from: f64, to: f64) -> Law {
    Law { intercept: 8000.0, mu: 0.0, slope: marshall_palmer_slope(rate), from, to }
}

/// Some laws of every kind, the narrow and the steep included.
fn laws() -> Vec<Law> {
    let mut laws = Vec::new();
    for rate in [0.001, 1.0, 25.0, 100.0, 2000.0] {
        for (from, to) in [(0.25, 6.0), (0.1, 8.0), (2.0, 2.01), (5.0, 10.0)] {
            for mu in [-0.9, 0.0, 3.0, 7.5] {
                let law = Law { mu, ..marshall_palmer(rate, from, to) };
                laws.push(law.normalised(rate, 1.2));
            }
            laws.push(Law { slope: 0.0, mu: 0.0, ..laws[0] }.normalised(rate, 1.2));
        }
    }
    laws
}

/// ∫ N f dD by Simpson's rule over 4096 steps in log D.
fn integral(law: &Law, from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 4096;
    let step = (to / from).ln() / f64::from(steps);
    let at = |i: i32| {
        let d = from * (f64::from(i) * step).exp();
        d * law.intercept * d.powf(law.mu) * (-law.slope * d).exp() * f(d)
    };
    let inner: f64 = (1..steps).map(|i| if i % 2 == 1 { 4.0 * at(i) } else { 2.0 * at(i) }).sum();
    step / 3.0 * (at(0) + inner + at(steps))
}

#[test]
fn marshall_and_palmers_law_has_its_published_moments() {
    let law = marshall_palmer(10.0, 0.25, 6.0);
    close(law.slope, 2.528040, 1e-6);
    close(law.number(), 1682.006, 1e-6);
    close(law.mean_diameter(), 0.645561, 1e-6);
    close(law.median_volume_diameter(), 1.45616, 1e-5);
    close(law.water(), 0.612731, 1e-6);
    close(law.extinction(), 7.572264e-4, 1e-6);
    close(law.rate(1.2), 11.6343, 1e-4);
    close(visibility_of(law.extinction()), 3956.2, 1e-4);
    for (u, d) in [(0.0, 0.25), (0.5, 0.524183), (0.99, 2.071618)] {
        close(law.quantile(0.0, u), d, 1e-6);
    }
    // Without the half of the light that diffraction takes out: Q = 1, not 2.
    assert!(law.extinction() < 1.5 * 7.572264e-4);
}

#[test]
fn moments_are_those_of_the_table_at_every_rate() {
    // Rate; N from 0.1, 0.25, 0.5 mm on; D0, W and extinction from 0.25 mm on; falls over label.
    let table = [
        (1.0, [1294.9, 700.1, 251.2], 0.9076, 0.08711, 1.6684e-4, 1.1787),
        (5.0, [2042.2, 1317.1, 634.0], 1.2612, 0.34144, 4.8347e-4, 1.1785),
        (25.0, [3113.9, 2277.4, 1352.1], 1.7613, 1.32379, 1.362_6e-3, 1.128_29),
        (50.0, [3704.9, 2826.9, 1801.1], 2.0308, 2.36189, 2.1175e-3, 1.0873),
        (100.0, [4391.0, 3475.4, 2353.6], 2.3316, 4.18369, 3.2778e-3, 1.0298),
    ];
    for (rate, numbers, d0, water, extinction, excess) in table {
        for (from, number) in [0.1, 0.25, 0.5].into_iter().zip(numbers) {
            close(marshall_palmer(rate, from, 6.0).number(), number, 2e-4);
        }
        let law = marshall_palmer(rate, 0.25, 6.0);
        close(law.median_volume_diameter(), d0, 1e-4);
        close(law.water(), water, 1e-4);
        close(law.extinction(), extinction, 1e-4);
        close(law.rate(1.2) / rate, excess, 1e-4);
    }
}

#[test]
fn a_normalised_law_rains_what_was_asked_and_keeps_its_median() {
    let law = marshall_palmer(10.0, 0.25, 6.0);
    let normalised = law.normalised(10.0, 1.2);
    close(normalised.rate(1.2), 10.0, 1e-12);
    close(normalised.intercept, 6876.2, 1e-4);
    for (of, with) in [
        (law.number(), normalised.number()),
        (law.water(), normalised.water()),
        (law.extinction(), normalised.extinction()),
    ] {
        close(with / of, 0.859525, 2e-6);
    }
    close(normalised.median_volume_diameter(), law.median_volume_diameter(), 1e-12);
    // In thin air drops fall faster, and fewer of them make the rate.
    close(law.normalised(10.0, 1.0).intercept * density_factor(1.0), normalised.intercept, 1e-12);
}

#[test]
fn gamma_laws_have_their_published_moments() {
    let table = [
        (8000.0, 1.2, [641.2, 1.1434, 0.20357, 2.969e-4, 3.262]),
        (8000.0, 1.7, [910.3, 1.6198, 0.81997, 8.441e-4, 16.72]),
        (3000.0, 2.2, [442.0, 2.0962, 0.86242, 6.860e-4, 20.47]),
    ];
    for (n_w, d_m, expected) in table {
        // Ulbrich's normalised form; Γ(7) = 720.
        let f = 6.0 / 256.0 * 7.0_f64.powi(7) / 720.0;
        let intercept = n_w * f / f64::powi(d_m, 3);
        let law = Law { intercept, mu: 3.0, slope: 7.0 / d_m, from: 0.1, to: 8.0 };
        let found = [
            law.number(),
            law.median_volume_diameter(),
            law.water(),
            law.extinction(),
            law.rate(1.2),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            close(found, expected, 3e-4);
        }
    }
}

/// Rain with a gamma law of sizes.
fn gamma(rate: f64, mu: f64) -> RealRain {
    RealRain { rate, mu, sizes: Sizes::Gamma, ..RealRain::default() }
}

#[test]
fn a_gamma_law_for_a_rate_is_ulbrichs() {
    // Rate, μ; Λ, number, median-volume diameter, water, extinction, visibility.
    let table = [
        (5.0, 3.0, [5.2843, 650.8, 1.262, 0.2901, 3.825e-4, 7831.0]),
        (25.0, 0.0, [2.0103, 1806.0, 1.826, 1.150, 1.143e-3, 2622.0]),
        (25.0, 3.0, [4.2857, 1538.0, 1.556, 1.257, 1.346e-3, 2225.0]),
        (100.0, 3.0, [3.5725, 3220.0, 1.867, 4.496, 4.015e-3, 746.0]),
    ];
    for (rate, mu, expected) in table {
        let law = gamma(rate, mu).law();
        let found = [
            law.slope,
            law.number(),
            law.median_volume_diameter(),
            law.water(),
            law.extinction(),
            visibility_of(law.extinction()),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            close(found, expected, 4e-4);
        }
        // Its N0: 6·10⁴ m⁻³ cm^-(1+μ) at μ = 0, and e^9.6 times that at 3.
        let intercept = if mu == 0.0 { 6000.0 } else { 6.0 * 14_764.781_566 };
        close(law.intercept, intercept, 1e-9);
        close(law.rate(1.2), rate, 1e-12);
    }
}

/// Willis 1984: μ = 2.5 and a median-volume diameter of 1.57 W^0.168 mm, W the water in g/m³.
#[test]
fn a_law_of_a_median_diameter_is_willis() {
    for (rate, [d0, number, visibility]) in
        [(25.0, [1.624, 1428.0, 2364.0]), (100.0, [2.008, 2714.0, 827.0])]
    {
        let mut rain = RealRain { median_diameter: Some(1.0), ..gamma(rate, 2.5) };
        for _ in 0..40 {
            rain.median_diameter = Some(1.57 * rain.law().water().powf(0.168));
        }
        let law = rain.law();
        close(rain.median_diameter.expect("it is given"), d0, 4e-4);
        close(law.slope, 6.17 / rain.median_diameter.expect("it is given"), 1e-12);
        close(law.median_volume_diameter(), d0, 5e-4);
        close(law.number(), number, 4e-4);
        close(visibility_of(law.extinction()), visibility, 4e-4);
    }
    // Whatever the rate, the sizes are those that were given.
    let of = |rate| RealRain { median_diameter: Some(1.8), ..gamma(rate, 4.0) }.law();
    close(of(100.0).number(), 50.0 * of(2.0).number(), 1e-12);
}

/// Gamma laws at the ends of what a scene may say: those that are accepted rain what was asked, in their air, and have
/// moments; all others are refused, and the words name μ and the mend.
#[test]
fn every_gamma_law_rains_what_was_asked_or_is_refused() {
    let (mut drawn, mut refused) = (0, 0);
    for rate in [0.001, 0.1, 25.0, 2000.0] {
        for mu in [-0.999_999, -0.5, 0.0, 3.0, 20.0, 50.0] {
            for diameters in [[0.25, 6.0], [0.01, 10.0], [0.01, 0.0102], [9.9, 10.0], [2.0, 2.01]] {
                for air_density in [0.1, 1.2, 10.0] {
                    for share in [None, Some(0.0), Some(0.5), Some(1.0)] {
                        let [from, to] = diameters;
                        let median_diameter =
                            share.map(|share: f64| (from + share * (to - from)).min(to));
                        let rain =
                            RealRain { diameters, air_density, median_diameter, ..gamma(rate, mu) };
                        let scene =
                            Scene { rain: Some(RainSettings::of(rain)), ..Scene::default() };
                        if let Err(error) = scene.validate("test") {
                            let (error, mu) = (error.to_string(), format!("mu = {mu} "));
                            assert!(
                                error.contains(&mu) && error.contains("give median_diameter"),
                                "{rain:?}: {error}"
                            );
                            assert!(share.is_none() && !error.contains('\n'), "{error}");
                            refused += 1;
                            continue;
                        }
                        let law = rain.law();
                        close(rain.rate_that_falls(), rate, 1e-8);
                        // By sums that share no code with the law.
                        let falls = integral(&law, from, to, |d| {
                            d.powi(3) * terminal_speed(d, air_density)
                        });
                        close(6.0 * PI * 1e-4 * falls, rate, 2e-5);
                        let d0 = law.median_volume_diameter();
                        assert!((from..=to).contains(&d0), "{rain:?}: {d0}");
                        assert!(law.number().is_finite() && law.number() > 0.0, "{rain:?}");
                        let sum: f64 = rain.classes().iter().map(|class| class.number).sum();
                        close(sum, law.number(), 1e-8);
                        drawn += 1;
                    }
                }
            }
        }
    }
    println!("{drawn} laws, {refused} refused");
    assert!(drawn > 1000 && refused > 60);
}

/// Thin air: drops fall faster, so fewer of them make the rate.
#[test]
fn a_gamma_law_rains_its_rate_in_thin_air() {
    let thin = RealRain { air_density: 0.7, ..gamma(25.0, 3.0) };
    let (law, usual) = (thin.law(), gamma(25.0, 3.0).law());
    close(law.rate(0.7), 25.0, 1e-12);
    close(law.intercept, usual.intercept, 1e-15);
    // The law of the rate that the same drops make in the table's air.
    close(law.slope, gamma(25.0 / density_factor(0.7), 3.0).law().slope, 1e-12);
    assert!(law.slope > usual.slope && law.number() < usual.number());
}

#[test]
fn closed_forms_are_the_integrals_for_every_law() {
    let nearly_flat =
        [1e-12, 1e-4, 0.009, 0.011].map(|slope| Law { slope: slope / 6.0, mu: 20.0, ..laws()[0] });
    for law in laws().into_iter().chain(nearly_flat) {
        for k in 0..=4 {
            let expected = integral(&law, law.from, law.to, |d| d.powi(k));
            close(law.moment(f64::from(k)), expected, 1e-8);
        }
        let middle = (law.from * law.to).sqrt();
        let upper = integral(&law, middle, law.to, |d| d.powi(2));
        close(law.moment_between(2.0, middle, law.to), upper, 1e-8);
        // The speed's table has corners, which cost the sum its order.
        let falls = integral(&law, law.from, law.to, |d| d.powi(3) * terminal_speed(d, 1.2));
        close(law.rate(1.2), 6.0 * PI * 1e-4 * falls, 1e-5);
        for u in [0.01, 0.5, 0.99] {
            let below = integral(&law, law.from, law.quantile(0.0, u), |_| 1.0);
            close(below / law.number(), u, 1e-7);
        }
    }
}

#[test]
fn speeds_are_those_of_gunn_and_kinzer() {
    for (d, v) in [(0.25, 0.94500), (1.1, 4.33500), (3.3, 8.35000), (0.05, 0.135), (9.0, 9.17)] {
        close(terminal_speed(d, 1.2), v, 1e-9);
    }
    close(density_factor(1.0), 1.075654, 1e-6);
    close(terminal_speed(2.0, 1.0), 6.49 * 1.075654, 1e-6);
    // A power law that is in use is half as fast again for drops of half a millimetre.
    let power = |d: f64| 3.778 * d.powf(0.67);
    assert!(power(0.5) / terminal_speed(0.5, 1.2) > 1.15);
}

#[test]
fn classes_share_out_the_law() {
    let edges = [
        0.25, 0.307, 0.364, 0.422, 0.480, 0.542, 0.604, 0.669, 0.733, 0.797, 0.861, 0.928, 1.000,
        1.084, 1.168, 1.261, 1.358, 1.460, 1.567, 1.681, 1.798, 1.926, 2.054, 2.179, 2.316, 2.467,
        2.646, 2.854, 3.082, 3.354, 3.693, 4.184, 6.0,
    ];
    let all = classes(&marshall_palmer(25.0, 0.25, 6.0), 1.2);
    assert_eq!(all.len() as u32, CLASSES);
    for (class, edges) in all.iter().zip(edges.windows(2)) {
        assert!((class.from - edges[0]).abs() < 1e-3 && (class.to - edges[1]).abs() < 1e-3);
    }
    for law in laws() {
        let classes = classes(&law, 1.0);
        let sum = |k| classes.iter().map(|c| law.moment_between(k, c.from, c.to)).sum::<f64>();
        close(classes.iter().map(|class| class.number).sum(), law.number(), 1e-9);
        for k in [0.0, 2.0, 3.0] {
            close(sum(k), law.moment(k), 1e-9);
        }
        let falls: f64 = classes
            .iter()
            .map(|class| class.speed * law.moment_between(3.0, class.from, class.to))
            .sum();
        close(6.0 * PI * 1e-4 * falls, law.rate(1.0), 1e-9);
        for pair in classes.windows(2) {
            assert!(pair[0].to == pair[1].from && pair[0].speed < pair[1].speed);
        }
    }
}

#[test]
fn classes_fall_nearly_as_fast_as_their_drops() {
    for (rate, rms) in [(5.0, 0.027), (25.0, 0.022), (100.0, 0.018)] {
        let law = marshall_palmer(rate, 0.25, 6.0);
        let squares: f64 = classes(&law, 1.2)
            .iter()
            .map(|class| {
                integral(&law, class.from, class.to, |d| {
                    (d * (class.speed / terminal_speed(d, 1.2) - 1.0)).powi(2)
                })
            })
            .sum();
        close((squares / law.moment(2.0)).sqrt(), rms, 0.03);
    }
}

const FOCAL: f64 = 886.810_01;

fn square(extent: f64) -> Frustum {
    Frustum { focal_px: FOCAL, width: 1024.0, height: 1024.0, extent }
}

#[test]
fn single_drops_have_the_size_and_the_streak_of_their_depth() {
    let cases = [
        (1.0, 2.0, 1.0 / 60.0, 0.221703, 29.782036),
        (3.0, 10.0, 1.0 / 250.0, 0.133022, 2.859075),
        (0.5, 1.0, 1.0 / 1000.0, 0.221703, 1.826829),
    ];
    for (d, z, shutter, radius, streak) in cases {
        let speed = terminal_speed(d, 1.2);
        close(radius_px(FOCAL, d, z), radius, 5e-6);
        close(streak_px(FOCAL, speed, shutter, z), streak, 1e-6);
        close(depth_of_radius(FOCAL, d, radius_px(FOCAL, d, z)), z, 1e-12);
    }
    close(streak_share(0.5), 0.833333, 1e-6);
    close(streak_share(3.0), 0.296296, 1e-5);
}

#[test]
fn the_drops_in_view_are_counted() {
    let law = marshall_palmer(10.0, 0.25, 6.0);
    for (radius, count) in [(1.0, 45.341), (0.1, 45341.0), (0.05, 3.6273e5)] {
        close(square(f64::INFINITY).drops_above(&law, radius), count, 2e-5);
    }
    let law = marshall_palmer(25.0, 0.25, 6.0);
    close(square(f64::INFINITY).drops_above(&law, 0.02), 1.224e7, 1e-3);
    // Cut at 0.05 px by the budget that this cut-off needs.
    let budget = square(f64::INFINITY).drops_above(&law, 0.05);
    close(cutoff_of_budget(&law, &square(30.0), budget), 0.05, 1e-12);
    close(starts(&law, FOCAL, 0.05), 53.21, 1e-4);
}

/// Counts of drops placed at random, by depth and distance: no integral in common with the closed form.
#[test]
fn a_near_end_of_the_rain_cuts_the_count() {
    let law = marshall_palmer(25.0, 0.25, 6.0);
    for extent in [2.0, 10.0, 40.0, 57.0] {
        let mut random = 1_u64;
        let mut uniform = move || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((random >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        // Directions uniform over the image plane, depths up to the extent; weights z² / f².
        let (trials, half_tan) = (400_000, 512.0 / FOCAL);
        let mut sum = 0.0;
        for _ in 0..trials {
            let (x, y) = (2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0);
            let depth = extent * uniform();
            let distance = depth * (1.0 + half_tan * half_tan * (x * x + y * y)).sqrt();
            let least = 2e3 * 0.05 * depth / FOCAL;
            if distance < extent && least < law.to {
                let from = law.from.max(least);
                let drops = ((-law.slope * from).exp() - (-law.slope * law.to).exp()) / law.slope;
                sum += 8000.0 * drops * depth * depth;
            }
        }
        let expected = sum / f64::from(trials) * extent * (2.0 * half_tan).powi(2);
        close(square(extent).drops_above(&law, 0.05), expected, 0.01);
    }
}

#[test]
fn the_medium_holds_what_is_not_drawn() {
    let law = marshall_palmer(25.0, 0.25, 6.0);
    for (depth, tau) in [(10.0, 0.001866), (30.0, 0.02347), (100.0, 0.11865)] {
        close(optical_depth(&law, Reach::new(FOCAL, 0.05, 0.0), depth), tau, 4e-4);
    }
    assert_eq!(optical_depth(&law, Reach::new(FOCAL, 0.05, 0.0), 1.0), 0.0);
    let law = marshall_palmer(10.0, 0.25, 6.0);
    // With a huge cut-off everything is medium.
    let all = optical_depth(&law, Reach::new(FOCAL, 1e6, 0.0), 50.0);
    close(all, 0.037861, 1e-4);
    close((-all).exp(), 0.962846, 1e-6);
}

/// One in (0.15 px over its radius)⁴ of the drops under 0.15 px is drawn, with the root of that as its share of the light: summed by
/// steps of diameter and depth, as are their number and the noise that they make.
#[test]
fn thinned_drops_and_the_medium_are_all_of_the_rain() {
    let law = marshall_palmer(25.0, 0.25, 6.0);
    let (cutoff, thinned) = (0.06, 0.15);
    let (sizes, depths) = (400, 2000);
    let frustum = square(60.0);
    for end in [10.0, 30.0, 60.0] {
        let (mut optical, mut drops) = (0.0, 0.0);
        for place in 0..sizes * depths {
            let diameter = 0.25 + 5.75 * (f64::from(place % sizes) + 0.5) / f64::from(sizes);
            let depth = end * (f64::from(place / sizes) + 0.5) / f64::from(depths);
            let number = law.intercept * (-law.slope * diameter).exp() * 5.75 * end
                / f64::from(sizes * depths);
            let radius = FOCAL * 5e-4 * diameter / depth;
            let share = match radius {
                _ if radius < cutoff => 0.0,
                _ if radius < thinned => (radius / thinned).powi(4),
                _ => 1.0,
            };
            optical += number * 0.25e-6 * PI * diameter * diameter * (1.0 - share.sqrt());
            let area = (frustum.width / FOCAL * depth) * (frustum.height / FOCAL * depth);
            drops += number * share * area;
        }
        let reach = Reach::new(FOCAL, cutoff, thinned);
        close(optical_depth(&law, reach, end), optical, 2e-3);
        // All that are drawn are nearer than 60 m.
        let far = Frustum { extent: f64::INFINITY, ..frustum };
        if end == 60.0 {
            close(drops_drawn(&far, &law, cutoff, thinned), drops, 5e-3);
        }
    }
}

/// The plain formulae are upper bounds: they leave out the drop's own size and the light's loss.
#[test]
fn a_pixel_flickers_as_much_as_single_drops_make_it() {
    let law = marshall_palmer(10.0, 0.25, 6.0);
    let bound = (PI * PI / 8.0 * FOCAL * 0.05 * 1e-9 * law.moment(3.0)).sqrt();
    close(bound, 0.008001, 1e-4);
    let m4 = 1e-12 * law.moment(4.0);
    close((PI * PI / 16.0 * FOCAL * FOCAL * m4 / 10.0).sqrt(), 0.009492, 1e-4);

    // Rate, nearest and farthest depth, shutter; the standard deviation of pixels into which every drop was
    // drawn, at random, good to 2 or 3 %.
    let by_depth = [
        (25.0, 10.0, 40.0, 0.0, 0.0121),
        (25.0, 3.0, 10.0, 0.0, 0.0198),
        (25.0, 10.0, 40.0, 1.0 / 60.0, 0.00538),
        (100.0, 10.0, 30.0, 1.0 / 250.0, 0.0161),
    ];
    for (rate, near, far, shutter, expected) in by_depth {
        let law = marshall_palmer(rate, 0.25, 6.0);
        let noise = square(far).noise_beyond(&law, 1.2, |_| near, shutter);
        // There was no rain before the nearest depth, and it took no light.
        close(noise * (law.extinction() * near).exp(), expected, 0.02);
    }
    let law = marshall_palmer(25.0, 0.25, 6.0);
    for (radius, shutter, expected) in
        [(0.1, 0.0, 0.01405), (0.05, 0.0, 0.00922), (0.1, 1.0 / 60.0, 0.00634)]
    {
        let noise = square(60.0).noise(&law, 1.2, radius, shutter);
        let reach = Reach::new(FOCAL, radius, 0.0);
        let drawn = law.extinction() * 60.0 - optical_depth(&law, reach, 60.0);
        close(noise * drawn.exp(), expected, 0.03);
    }
}

#[test]
fn what_is_left_to_the_medium_shows_no_single_drop() {
    let seen = 1.0 / 255.0;
    // 0.035 pixels over the root of the contrast (two digits are kept).
    close(unseen_radius(0.5, seen), 0.05, 1e-12);
    close(unseen_radius(0.1, seen), 0.11, 1e-12);
}
