//! The parts that run on the CPU, and the serial implementations of shaders: `cargo bench --bench cpu_parts`.
//!
//! A million drops of the paper's scene, the bundled sky, and one ray or texel of the optics.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::environment::levels::{levels, sample};
use raindrops::optics::{Intersection, level_half_angle, mask_intersection};
use raindrops::rain::clusters::Clusters;
use raindrops::rain::cull::count_visible;
use raindrops::rain::tick_of_seconds;
use raindrops::scene::Scene;

/// Rays of the optics' benchmarks: enough that a call's cost is in the figure and the clock's is not.
const RAYS: u32 = 1024;

fn rain(c: &mut Criterion) {
    let scene = Scene::default();
    let Some(rain) = scene.rain() else { return };
    let mut group = c.benchmark_group("rain");
    group.throughput(Throughput::Elements(rain.count.into()));
    // Milliseconds an iteration: ten of them say enough.
    group.sample_size(10);
    group.bench_function("place", |b| {
        let shift = rain.shift(tick_of_seconds(12.5));
        b.iter(|| (0..rain.count).for_each(|index| _ = black_box(rain.place(index, shift))));
    });
    group.bench_function("count_visible", |b| b.iter(|| count_visible(black_box(&scene))));
    group.bench_function("clusters", |b| b.iter(|| Clusters::new(black_box(&[rain]), &[])));
    group.finish();
}

fn environment(c: &mut Criterion) {
    let Ok(sky) = Environment::bundled() else { return };
    let mut group = c.benchmark_group("environment");
    group.sample_size(10);
    group.bench_function("bundled", |b| b.iter(Environment::bundled));
    group.bench_function("levels", |b| b.iter(|| levels(black_box(&sky))));
    group.finish();

    let chain = levels(&sky);
    let mut group = c.benchmark_group("environment/lookup");
    group.throughput(Throughput::Elements(RAYS.into()));
    group.bench_function("trilinear", |b| {
        b.iter(|| rays().map(|ray| sample(&chain, ray, 2.5)).sum::<DVec3>());
    });
    group.finish();
}

fn optics(c: &mut Criterion) {
    let mut group = c.benchmark_group("optics");
    group.throughput(Throughput::Elements(RAYS.into()));
    // A drop that fills the rays' bundle, so that all of them meet it.
    let (center, radius) = (DVec3::new(0.0, 0.0, -3.0), 2.0);
    group.bench_function("intersection", |b| {
        b.iter(|| rays().filter_map(|ray| Intersection::of_ray(ray, center, radius)).count());
    });
    group.bench_function("intersection, every direction and weight", |b| {
        b.iter(|| {
            let intersections = rays().filter_map(|ray| Intersection::of_ray(ray, center, radius));
            intersections.map(|e| all_orders(&e)).sum::<DVec3>()
        });
    });
    group.bench_function("mask_intersection", |b| {
        let half_angle = level_half_angle(3);
        b.iter(|| {
            let texels = (0..RAYS).map(|index| {
                let at = |i: u32| (f64::from(i) + 0.5) / 16.0 - 1.0;
                let intersection = mask_intersection(at(index % 32), at(index / 32), half_angle);
                intersection.reflected() + intersection.transmitted() * intersection.reflectance()
            });
            texels.sum::<DVec3>()
        });
    });
    group.finish();
}

/// Reflection, refraction and two internal reflections, each by its weight.
fn all_orders(intersection: &Intersection) -> DVec3 {
    let inside = (0..3).map(|k| {
        intersection.weight_of_internal_reflections(k) * intersection.after_internal_reflections(k)
    });
    intersection.reflectance() * intersection.reflected() + inside.sum::<DVec3>()
}

/// Unit directions about -z, up to 19° off.
fn rays() -> impl Iterator<Item = DVec3> {
    (0..RAYS).map(|index| {
        let at = |i: u32| (f64::from(i) + 0.5) / 64.0 - 0.25;
        DVec3::new(at(index % 32), at(index / 32), -1.0).normalize()
    })
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = rain, environment, optics
}
criterion_main!(benches);
