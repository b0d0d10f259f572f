//! Single models against what they approximate: directions in float32, the footprint off the axis,
//! billboards, white furnaces, and which combinations are refused.

use glam::{DMat3, DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::sets::constant;
use raindrops::gpu::{
    Binding, Bindings, Buffer, Commands, ComputePipeline, Device, Memory, Resource, Shader, Slot,
    Use, memory_barrier,
};
use raindrops::optics::{Intersection, mask_intersection};
use raindrops::picture::Picture;
use raindrops::plan::{Output, plan};
use raindrops::reference::paper::{Sprite, rotation};
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::camera::View;
use raindrops::scene::model::{
    Fresnel, Lookup, Optics, Order, Preset, Primitive, Reflection, Simulation, Weights,
};
use raindrops::scene::{ImageSize, ModelChoice, Scene};

use crate::common::picture::picture_of;
use crate::common::{on_device, one_drop};

/// Compiles a compute shader against the project's own includes.
fn compile(source: &str) -> Vec<u32> {
    let compiler = shaderc::Compiler::new().expect("a compiler");
    let mut options = shaderc::CompileOptions::new().expect("options");
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_include_callback(|name, _, _, _| {
        let resolved_name = format!("glsl/include/{name}");
        let content = std::fs::read_to_string(&resolved_name).map_err(|error| error.to_string())?;
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    let kind = shaderc::ShaderKind::Compute;
    let binary = compiler.compile_into_spirv(source, kind, "test.comp", "main", Some(&options));
    binary.expect("a shader that compiles").as_binary().to_vec()
}

/// Edge in pixels of the picture through which directions are compared, and its focal length.
const EDGE: u32 = 256;
const FOCAL: f32 = 128.0;

/// Reflected and transmitted direction at every pixel, by the shaders' closed form in float32.
fn directions_on_gpu(device: &std::sync::Arc<Device>, sphere: [f32; 4]) -> Vec<[[f32; 4]; 2]> {
    let words = compile(&format!(
        "#version 460
         #extension GL_GOOGLE_include_directive : require
         #include \"light_model.glsl\"
         #include \"optics.glsl\"
         layout(local_size_x = 64) in;
         layout(std430, set = 0, binding = 0) writeonly buffer Out {{ vec4 outs[]; }};
         layout(push_constant) uniform Push {{ vec4 sphere; }};
         void main() {{
             uint at = gl_GlobalInvocationID.x;
             vec2 offset = vec2(at % {EDGE}u, at / {EDGE}u) + 0.5 - 0.5 * {EDGE}.0;
             vec3 d = normalize(vec3(offset.x, -offset.y, -{FOCAL:?}));
             vec3 to_ray = cross(cross(d, sphere.xyz), d) / -sphere.w;
             float b = length(to_ray), held = min(b, 1.0);
             Intersection e = Intersection(d, to_ray / max(b, 1e-9), held, sqrt((1.0 - held) * (1.0 + held)));
             outs[2u * at] = vec4(reflected(e), b);
             outs[2u * at + 1u] = vec4(transmitted(e), b);
         }}"
    ));
    // SAFETY: the compiler made it, for these bindings.
    let shader = unsafe { Shader::new("directions", None, Box::leak(words.into_boxed_slice())) };
    let count = (EDGE * EDGE) as usize;
    let usage = ash::vk::BufferUsageFlags::STORAGE_BUFFER;
    let out = Buffer::new(device, "directions", 32 * count as u64, usage, Memory::Readback)
        .expect("a buffer");
    let slots = [(Slot::new(0, Binding::STORAGE_BUFFER), Resource::Buffer(&out))];
    let bindings = Bindings::of(device, "directions", &slots).expect("bindings");
    let constants = [[constant::INTERNAL_REFLECTIONS, 0]];
    let pipeline =
        ComputePipeline::new(device, &shader, &bindings, 16, &constants).expect("a pipeline");
    Commands::once(device, "directions", |commands| {
        let push = bytemuck::cast_slice(&sphere);
        pipeline.dispatch(commands, &bindings, 0, push, [EDGE * EDGE / 64, 1, 1]);
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::HostRead]);
    })
    .expect("directions");
    out.read(count)
}

/// Angle in degrees between two directions.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[test]
fn the_closed_form_in_float32_keeps_its_directions() {
    on_device(|device| {
        // On the axis, and 30, 45 and 60° off it; near and far.
        for (off_axis, distance) in [
            (0.0, 1.5),
            (0.0, 4.0),
            (30.0, 2.0),
            (30.0, 8.0),
            (45.0, 2.0),
            (45.0, 8.0),
            (40.0, 64.0),
        ] {
            let (sine, cosine) = f64::to_radians(off_axis).sin_cos();
            let center = (distance * DVec3::new(sine, 0.0, -cosine)).as_vec3();
            let found = directions_on_gpu(device, center.extend(1.0).to_array());
            let (mut worst, mut sum, mut count) = (0f64, 0.0, 0u32);
            for (at, [reflected, transmitted]) in (0u32..).zip(found) {
                let x = f64::from(at % EDGE) + 0.5 - 0.5 * f64::from(EDGE);
                let y = f64::from(at / EDGE) + 0.5 - 0.5 * f64::from(EDGE);
                let ray = DVec3::new(x, -y, -f64::from(FOCAL)).normalize();
                let Some(exact) = Intersection::of_ray(ray, center.as_dvec3(), 1.0) else {
                    continue;
                };
                if exact.impact_parameter >= 0.999 {
                    continue;
                }
                let direction = |d: [f32; 4]| Vec3::new(d[0], d[1], d[2]).as_dvec3();
                for (found, exact) in [
                    (direction(reflected), exact.reflected()),
                    (direction(transmitted), exact.transmitted()),
                ] {
                    let off = angle(found, exact);
                    worst = worst.max(off);
                    sum += off;
                    count += 1;
                }
            }
            println!(
                "{off_axis}° off the axis at {distance} radii: {:.1e}° mean, {worst:.1e}° at most \
                 ({count} directions)",
                sum / f64::from(count)
            );
            assert!(count > 20, "no pixel meets the drop");
            assert!(worst < 0.01, "{off_axis}°, {distance} radii: {worst}°");
        }
    });
}

/// Mean angles in degrees by which a square sprite turns reflections and refractions of a drop at
/// `off_axis` degrees: over its inscribed disc, where rays of the same pixels meet the drop. The sprite
/// is the one here, of the outline's place and area; or as published, about the projected centre and
/// sized by the distance.
fn billboard_angles(off_axis: f64, published: bool) -> [f64; 2] {
    let mut scene = one_drop(DVec3::NEG_Z, 1.0);
    scene.image = ImageSize { width: 1024, height: 1024 };
    let view: View = scene.view();
    let (sine, cosine) = off_axis.to_radians().sin_cos();
    let center = 64.0 * DVec3::new(sine, 0.0, -cosine);
    let mut sprite = Sprite::new(&view, &scene.camera, center, 1.0);
    let mut turn: DMat3 = rotation(center);
    if published {
        let middle = DVec2::splat(512.0);
        sprite.center = middle + DVec2::new(center.x, -center.y) / -center.z * view.focal_px;
        sprite.diameter = 2.0 * view.focal_px / (64f64 * 64.0 - 1.0).sqrt();
        // Equations 1 to 4 with u of unit length, V the view's up.
        let n = -center.normalize();
        let u = DVec3::Y.cross(n).normalize();
        turn = DMat3::from_cols(u, n.cross(u), n);
    }
    let half_angle = (1.0 / 64f64).asin();
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for row in 0..64 {
        for column in 0..64 {
            let st = (DVec2::new(column.into(), row.into()) + 0.5) / 32.0 - 1.0;
            let pixel = sprite.center + 0.5 * sprite.diameter * DVec2::new(st.x, -st.y);
            let exact = Intersection::of_ray(view.ray(pixel.x, pixel.y), center, 1.0);
            let (true, Some(exact)) = (st.length() < 1.0, exact) else { continue };
            let masked = mask_intersection(st.x, st.y, half_angle);
            sums[0] += angle(turn * masked.reflected(), exact.reflected());
            sums[1] += angle(turn * masked.transmitted(), exact.transmitted());
            count += 1.0;
        }
    }
    sums.map(|sum| sum / count)
}

#[test]
fn a_square_turns_directions_off_the_axis() {
    for off_axis in [30.0, 45.0, 60.0] {
        let [r, t] = billboard_angles(off_axis, false);
        let [r_published, t_published] = billboard_angles(off_axis, true);
        println!(
            "{off_axis}°: reflections {r:.1}° off, refractions {t:.1}°; as published \
             {r_published:.1}°, {t_published:.1}°"
        );
        assert!(r > 5.0 && t > 2.0, "{off_axis}°: the square is said to be wrong here");
        assert!(r < r_published && t < t_published, "{off_axis}°: no better than published");
    }
    let [r, t] = billboard_angles(0.0, false);
    assert!(r < 0.1 && t < 0.1, "on the axis it is right: {r}°, {t}°");
}

fn picture(
    device: &std::sync::Arc<Device>,
    scene: &Scene,
    environment: &Environment,
    model: ModelChoice,
) -> Picture {
    let scene = Scene { model, ..scene.clone() };
    picture_of(device, &scene, environment)
}

/// What a picture lacks of white, summed: a drop without its reflection is as dark as it is large.
fn darkness(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| 1.0 - f64::from(pixel.y)).sum()
}

#[test]
fn the_footprint_has_the_true_area_off_the_axis() {
    on_device(|device| {
        let white = Environment::constant(Vec3::ONE);
        for off_axis in [0.0, 30.0, 45.0, 60.0] {
            let (sine, cosine) = f64::to_radians(off_axis).sin_cos();
            let mut scene = one_drop(12.0 * DVec3::new(sine, 0.0, -cosine), 1.0);
            scene.camera.vertical_fov = 2.0 * 62f64.to_radians().tan().atan().to_degrees() + 6.0;
            scene.image = ImageSize { width: 512, height: 512 };
            let truth = Truth { samples: 64, reflection: false, ..Truth::default() };
            let truth = darkness(&Tracer::new(&scene, &white, truth).picture());
            for preset in [Preset::Fast, Preset::Exact] {
                let model = ModelChoice {
                    preset,
                    reflection: Some(Reflection::Off),
                    // So many that what the rim lacks is not left to one place in a pixel.
                    samples: Some(16),
                    ..ModelChoice::default()
                };
                let found = darkness(&picture(device, &scene, &white, model));
                println!("{off_axis}°, {preset}: area {:.4} of the truth's", found / truth);
                assert!(
                    (found / truth - 1.0).abs() < 0.02,
                    "{off_axis}°, {preset}: {found}, {truth}"
                );
            }
        }
    });
}

#[test]
fn every_optics_of_a_billboard_is_white_in_a_white_furnace() {
    on_device(|device| {
        let white = Environment::constant(Vec3::ONE);
        let mut scene = one_drop(DVec3::new(0.3, 0.2, -3.0), 1.0);
        scene.image = ImageSize { width: 128, height: 128 };
        for optics in [
            Optics::Mask,
            Optics::MaskF32,
            Optics::MaskSnorm16,
            Optics::SingleMask,
            Optics::Radial,
            Optics::ClosedForm,
            Optics::Far,
            Optics::Appearance,
        ] {
            for order in [Order::Unsorted, Order::AlphaToCoverage] {
                let model = ModelChoice {
                    preset: Preset::Paper,
                    optics: Some(optics),
                    order: Some(order),
                    ..ModelChoice::default()
                };
                let found = picture(device, &scene, &white, model);
                let off = |pixel: &Vec3| (*pixel - Vec3::ONE).abs().max_element();
                let worst = found.pixels.iter().map(off).fold(0.0, f32::max);
                println!("{optics}, {order}: off white by {worst:.1e}");
                assert!(worst < 3e-3, "{optics}, {order}: off white by {worst}");
            }
        }
        // The control: physical weights without internal reflections lose what these carry.
        let model = ModelChoice {
            preset: Preset::Paper,
            weights: Some(Weights::Physical),
            ..ModelChoice::default()
        };
        let lost = darkness(&picture(device, &scene, &white, model));
        assert!(lost > 10.0, "nothing is lost: {lost}");
    });
}

#[test]
fn combinations_without_sense_are_refused_with_a_reason() {
    let sky = Environment::constant(Vec3::ONE);
    let paper = ModelChoice { preset: Preset::Paper, ..ModelChoice::default() };
    let tile = ModelChoice { primitive: Some(Primitive::Tile), ..paper };
    let cases = [
        (tile, "mask"),
        (ModelChoice { optics: Some(Optics::Far), ..tile }, "1.5 pixels"),
        (ModelChoice { order: Some(Order::Sorted), ..paper }, "tiles"),
        (ModelChoice { internal_reflections: Some(1), ..paper }, "no internal reflections"),
        (ModelChoice { optics: Some(Optics::Far), samples: Some(4), ..paper }, "samples must be 1"),
        (
            ModelChoice {
                preset: Preset::Fast,
                simulation: Some(Simulation::Stored),
                ..ModelChoice::default()
            },
            "clusters",
        ),
        (
            ModelChoice { preset: Preset::Fast, order: Some(Order::Unsorted), ..paper },
            "exact order",
        ),
    ];
    for (number, (model, reason)) in cases.into_iter().enumerate() {
        let scene = Scene { model, ..Scene::default() };
        let refused = plan(&scene, &sky, Output::Display).expect_err("a refusal").to_string();
        assert!(refused.contains(reason) && !refused.contains('\n'), "{number}: {refused}");
    }
    // What makes sense is planned as asked.
    let model = ModelChoice {
        optics: Some(Optics::Radial),
        primitive: Some(Primitive::Quad),
        order: Some(Order::AlphaToCoverage),
        samples: Some(4),
        fresnel: Some(Fresnel::Schlick),
        lookup: Some(Lookup::Finest),
        internal_reflections: Some(2),
        ..paper
    };
    let planned =
        plan(&Scene { model, ..Scene::default() }, &sky, Output::Display).expect("a plan");
    assert_eq!(planned.optics, Optics::Radial);
    assert_eq!((planned.samples, planned.light.internal_reflections), (4, 2));
}
