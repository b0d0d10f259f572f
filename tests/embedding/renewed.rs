//! Light that a host renews: that of the same environment when it is prepared on the CPU.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use ash::vk;
use glam::{DVec3, Vec3};
use half::f16;
use raindrops::device::{Device, HostImage, ImageState, requirements};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::{box_filter, rel_mse};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    FrameInput, HostEnvironment, Lighting, LiveInfo, RainField, View, ViewInfo,
};
use raindrops::scene::model::{Fresnel, Preset};
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::{self, with_halo};
use crate::embedded::{Embedded, SIZE, environment, on_host, scene};
use crate::host::{Host, Texture};

/// Sun and all; another image shows in the frame that it is named with, and stays.
#[test]
fn renewed_light_is_that_of_the_same_environment() {
    let scene = scene(Preset::Fast);
    // The second environment is the first, turned by a quarter.
    let (sky, turned) = (environment(), {
        let sky = environment();
        common::painted(256, move |d| sky.radiance(DVec3::new(-d.z, d.y, d.x)).as_vec3())
    });
    on_host(Preset::Fast, |host, device| {
        let [expected, other] = [&sky, &turned].map(|around| fixed(host, device, &scene, around));
        let images = [&sky, &turned].map(|environment| uploaded(host, environment));
        let mut embedded = live(host, device, &scene, &sky);
        let difference = error(&expected, &other);
        let first = frame(&mut embedded, host, 0, &scene, Some(&images[0]));
        println!("relMSE {:.7}; of another environment {difference:.4}", error(&expected, &first));
        assert!(error(&expected, &first) < 0.002 * difference);
        let kept = frame(&mut embedded, host, 1, &scene, None);
        assert!(kept == first, "it stays");
        let turned = frame(&mut embedded, host, 2, &scene, Some(&images[1]));
        assert!(error(&other, &turned) < 0.002 * difference);
        host.destroy_image(embedded.target);
        drop(embedded.view);
        images.into_iter().for_each(|image| host.destroy_image(image));
    });
}

/// Neither one that was never there nor one that has set is seen in small drops.
#[test]
fn a_sun_that_is_gone_leaves_no_glint() {
    let mut scene = scene(Preset::Fast);
    let rain = scene.rain.get_or_insert_default();
    (rain.count, rain.half_extent, rain.radius) = (100_000, DVec3::splat(60.0), 0.05);
    let sun = DVec3::new(0.3, 0.4, -1.0).normalize();
    let [dark, sky] = [0.4, 6e4].map(|lit| {
        common::painted(256, move |d| Vec3::splat(if d.dot(sun) > 0.9998 { lit } else { 0.4 }))
    });
    on_host(Preset::Fast, |host, device| {
        let expected = fixed(host, device, &scene, &dark);
        let images = [&dark, &sky].map(|environment| uploaded(host, environment));
        let mut embedded = live(host, device, &scene, &sky);
        for (number, is_lit) in [false, true, false].into_iter().enumerate() {
            let image = &images[usize::from(is_lit)];
            let found = frame(&mut embedded, host, number, &scene, Some(image));
            let found = error(&expected, &found);
            println!("frame {number}: relMSE {found:.1e}");
            assert!(if is_lit { found > 1.0 } else { found < 1e-5 }, "frame {number}: {found}");
        }
        host.destroy_image(embedded.target);
        drop(embedded.view);
        images.into_iter().for_each(|image| host.destroy_image(image));
    });
}

/// A frame in the light of a host's image is as one in the same light that does not change, to this error.
fn assert_renewed_is_fixed(scene: &Scene, sky: &Environment, bound: f64) {
    on_host(Preset::Fast, |host, device| {
        let expected = fixed(host, device, scene, sky);
        let image = uploaded(host, sky);
        let mut embedded = live(host, device, scene, sky);
        let found = frame(&mut embedded, host, 0, scene, Some(&image));
        let found = error(&expected, &found);
        println!("relMSE {found:.1e}");
        assert!(found < bound);
        host.destroy_image(embedded.target);
        drop(embedded.view);
        host.destroy_image(image);
    });
}

/// A halo of some degrees around a sun is no part of it: a large drop shows its shape.
#[test]
fn a_renewed_halo_stays_around_its_sun() {
    let sky = with_halo(DVec3::new(-0.25, 0.1, -1.0).normalize());
    let mut scene = scene(Preset::Fast);
    scene.rain = None;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, -2.0), 1.0)];
    scene.camera.vertical_fov = 40.0;
    assert_renewed_is_fixed(&scene, &sky, 1e-4);
}

/// Near a pole a level's texels are narrow; what each averages is as wide as at the equator.
#[test]
fn renewed_light_is_the_same_at_the_pole() {
    let wedges = common::painted(256, |d| {
        Vec3::splat(if (8.0 * d.x.atan2(-d.z)).sin() > 0.0 { 3.0 } else { 0.3 })
    });
    let mut scene = scene(Preset::Fast);
    scene.camera.target = scene.camera.position + DVec3::Y;
    scene.camera.vertical_fov = 40.0;
    scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.2, 5.0, 0.1), 1.0)];
    assert_renewed_is_fixed(&scene, &wedges, 1e-5);
}

fn error(expected: &Picture, found: &Picture) -> f64 {
    rel_mse(&box_filter(expected), &box_filter(found), None)
}

/// A host may hold its queue's lock while it records: another view of the same light that waits for it keeps nothing that a frame
/// needs.
#[test]
fn a_frame_is_recorded_while_another_view_waits_for_the_queue() {
    let _alone = crate::common::layer::alone();
    let host = crate::embedded::host(Preset::Fast);
    let (scene, sky) = (scene(Preset::Fast), environment());
    let (waits, waiting) = mpsc::channel();
    let (recorded, goes_on) = mpsc::channel();
    let (is_held, goes_on) = (Arc::new(AtomicBool::new(false)), Mutex::new(goes_on));
    let (mut lent, held) = (host.lent(), is_held.clone());
    lent.queue_lock = Some(Arc::new(move |work: &mut dyn FnMut()| {
        if held.load(SeqCst) {
            waits.send(()).expect("a frame is recorded");
            // So long only if the frame waits as well.
            let wait = goes_on.lock().expect("no panic").recv_timeout(Duration::from_secs(60));
            held.store(wait.is_ok(), SeqCst);
        }
        work();
    }));
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(lent, &requirements(Preset::Fast)) }.expect("a device");
    let live = LiveInfo { height: sky.height(), cube: false, ..LiveInfo::default() };
    let light = Arc::new(Lighting::live(&device, live).expect("light"));
    let rain = Arc::new(RainField::new(&device, &scene));
    let view = |scene: &Scene| {
        let plan = plan(scene, &sky, Output::Radiance).expect("a plan");
        View::new(&light, &rain, scene, &plan, &ViewInfo::default()).expect("a view")
    };
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    embedded.view = view(&scene);
    let image = uploaded(&host, &sky);
    let mut other = scene.clone();
    other.model.fresnel = Some(Fresnel::Schlick);
    is_held.store(true, SeqCst);
    let frames = std::thread::scope(|threads| {
        let made = threads.spawn(|| drop(view(&other)));
        let mut frames = 0;
        while !made.is_finished() {
            if waiting.recv_timeout(Duration::from_millis(10)).is_err() {
                continue;
            }
            host.begin(embedded.commands[0]);
            let input = in_light_of(FrameInput::new(&scene, embedded.output()), &image);
            // SAFETY: as they are described; it is thrown away.
            unsafe { embedded.view.record(embedded.commands[0], 0, &input) }.expect("a recording");
            host.end(embedded.commands[0]);
            // SAFETY: see above.
            unsafe { embedded.view.retired(0) }.expect("no report");
            frames += 1;
            recorded.send(()).expect("the view is made");
        }
        frames
    });
    assert!(is_held.load(SeqCst), "a frame waited for a view that waited for the queue");
    assert!(frames > 0, "the control: the view waits for the queue");
    is_held.store(false, SeqCst);
    host.destroy_image(embedded.target);
    host.destroy_image(image);
    drop((embedded.view, light, rain, device));
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// Rain in other light than that of `Embedded::new`.
fn by(
    host: &Host,
    device: &Arc<Device>,
    scene: &Scene,
    (sky, light): (&Environment, Lighting),
) -> Embedded {
    let info = ViewInfo::default();
    let mut embedded = Embedded::new(host, device, scene, &info);
    let plan = plan(scene, sky, Output::Radiance).expect("a plan");
    let rain = Arc::new(RainField::new(device, scene));
    embedded.view = View::new(&Arc::new(light), &rain, scene, &plan, &info).expect("a view");
    embedded
}

/// In an environment that the CPU prepares.
fn fixed(host: &Host, device: &Arc<Device>, scene: &Scene, sky: &Environment) -> Picture {
    let light = Lighting::new(device, sky).expect("light");
    let mut embedded = by(host, device, scene, (sky, light));
    let (picture, _) = embedded.frame(host, 0, scene);
    host.destroy_image(embedded.target);
    as_picture(&picture)
}

/// Whose light a host renews, as large as `sky`, by which it is planned.
fn live(host: &Host, device: &Arc<Device>, scene: &Scene, sky: &Environment) -> Embedded {
    let info = LiveInfo { height: sky.height(), cube: false, ..LiveInfo::default() };
    by(host, device, scene, (sky, Lighting::live(device, info).expect("light")))
}

fn uploaded(host: &Host, sky: &Environment) -> Texture {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let size = (sky.width(), sky.height());
    let image = host.image(vk::Format::R16G16B16A16_SFLOAT, size, 1, usage);
    let texels = sky.texels().iter();
    let halves: Vec<[f16; 4]> =
        texels.map(|t| t.extend(1.0).to_array().map(f16::from_f32)).collect();
    host.write(&image, bytemuck::cast_slice(&halves));
    image
}

fn in_light_of<'a>(input: FrameInput<'a>, named: &Texture) -> FrameInput<'a> {
    let Texture { image, view, format, size, .. } = *named;
    let (entry, exit) = (ImageState::SAMPLED, ImageState::SAMPLED);
    let image = HostImage { entry, exit, ..HostImage::color(image, view, format, size) };
    input.around(HostEnvironment::new(image))
}

/// A frame in the light of an image, or in that which is there.
fn frame(
    embedded: &mut Embedded,
    host: &Host,
    number: usize,
    scene: &Scene,
    named: Option<&Texture>,
) -> Picture {
    let input = FrameInput::new(scene, embedded.output());
    let input = named.iter().fold(input, |input, image| in_light_of(input, image));
    let report = embedded.draw(host, number % 2, &input);
    println!("{:?}", &report.passes_ms[..2]);
    as_picture(&embedded.read(host))
}

fn as_picture(pixels: &[[f16; 4]]) -> Picture {
    let light = |p: &[f16; 4]| Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32());
    Picture { width: SIZE.0, height: SIZE.1, pixels: pixels.iter().map(light).collect() }
}
