//! Every pipeline that scenes and models ask for, made by compilers of cards that are not there.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use clap::ValueEnum;
use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::gpu::{Compiled, Device, Instance, Machine, PointRules, Validation};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::Scene;
use raindrops::scene::model::{
    FarRain, Fresnel, Lens, Lookup, Motion, Optics, Order, Primitive, Reflection, ShapeModel,
    Simulation, Weights,
};
use rayon::prelude::*;

/// The family of cards that is compiled for, unless `RAINDROPS_TEST_FAMILY` names another.
const FAMILY: &str = "NAVI21";

/// Settings of a key of `[model]`, each as `--set` has it.
fn values<T: ValueEnum>(key: &str) -> Vec<String> {
    let names = T::value_variants().iter().filter_map(|value| value.to_possible_value());
    names.map(|value| format!("model.{key}={}", value.get_name())).collect()
}

/// The axes of the models.
fn axes() -> Vec<Vec<String>> {
    let numbers =
        |key: &str, all: &[&str]| all.iter().map(|n| format!("model.{key}={n}")).collect();
    vec![
        values::<Optics>("optics"),
        values::<Primitive>("primitive"),
        values::<Order>("order"),
        values::<Simulation>("simulation"),
        values::<Weights>("weights"),
        values::<Fresnel>("fresnel"),
        values::<Reflection>("reflection"),
        values::<Lookup>("lookup"),
        values::<FarRain>("far_rain"),
        values::<Motion>("motion"),
        values::<Lens>("lens"),
        values::<ShapeModel>("shape"),
        numbers("samples", &["1", "16"]),
        numbers("internal_reflections", &["0", "1", "2"]),
    ]
}

/// Scenes of every kind that passes tell apart: `--set` by `--set`.
const SCENES: [&[&str]; 4] = [
    &["rain.count=100"],
    &[
        "rain.count=100",
        "camera.shutter=0.1",
        "camera.aperture=0.1",
        "camera.focus=5",
        "water.index=1.332,1.334,1.338",
    ],
    &["rain.rate=25", "rain.extent=20"],
    &[
        "rain.rate=25",
        "rain.extent=20",
        "camera.shutter=0.01",
        "camera.aperture=0.01",
        "camera.focus=2",
    ],
];

/// Scenes that ask for passes of their own: drops in motion, long lists, a pane in focus and out of it, a shelter.
const OTHERS: [&[&str]; 5] = [
    &["drop=[{center=[0,0,-3],radius=0.3,velocity=[1,0,0]}]", "camera.shutter=0.01"],
    &["rain.count=400000"],
    &["pane.distance=0.3", "pane.drop=[{at=[0,0],radius=0.02}]"],
    &["pane.distance=0.3", "pane.drop=[{at=[0,0],radius=0.02}]", "camera.aperture=0.05"],
    &[
        "rain.rate=25",
        "rain.extent=20",
        concat!("shelter.height=", env!("CARGO_MANIFEST_DIR"), "/assets/porch/heights.png"),
        "shelter.from=-8,-8",
        "shelter.to=8,8",
    ],
];

/// Makes what a scene with these settings is drawn by, as a picture and as layers; whether there is a plan for it.
fn make(device: &Arc<Device>, settings: &[String], light: &Environment) -> bool {
    let size = ["image.width=16", "image.height=16", "model.mask_size=16"];
    let edits: Vec<String> = settings.iter().cloned().chain(size.map(String::from)).collect();
    let Ok(mut scene) = Scene::load_edited(None, &edits) else { return false };
    scene.read_shelter().expect("a height map");
    let is_made = |output| {
        let plan = plan(&scene, light, output);
        plan.is_ok_and(|plan| Renderer::new(device, &scene, light, &plan).is_ok())
    };
    // An axis does not change what layers need.
    let of_layers = settings.len() <= SCENES[3].len() + 1 && is_made(Output::Layers);
    is_made(Output::Display) || of_layers
}

/// Everything that is made: scene by scene and preset by preset, each axis alone; and by `fast` and `paper`, of what moves and
/// is out of focus, each pair of axes.
fn settings() -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = Vec::new();
    for scene in OTHERS {
        for preset in ["model.preset=fast", "model.preset=exact"] {
            all.push([scene, &[preset]].concat().iter().map(|edit| edit.to_string()).collect());
        }
    }
    for (number, scene) in SCENES.iter().enumerate() {
        for preset in ["paper", "fast", "exact", "paper-compact"] {
            let with = |others: &[&String]| {
                let preset = format!("model.preset={preset}");
                let scene = scene.iter().map(|edit| edit.to_string());
                scene.chain([preset]).chain(others.iter().map(|edit| edit.to_string())).collect()
            };
            all.push(with(&[]));
            let axes = axes();
            all.extend(axes.iter().flatten().map(|value| with(&[value])));
            if number % 2 == 0 || !["fast", "paper"].contains(&preset) {
                continue;
            }
            for (first, one) in axes.iter().enumerate() {
                for other in &axes[first + 1..] {
                    let pairs = one.iter().flat_map(|a| other.iter().map(move |b| [a, b]));
                    all.extend(pairs.map(|pair| with(&pair)));
                }
            }
        }
    }
    all
}

/// Figures of all variants of a shader: how many there are, and the most of each figure.
type Table = BTreeMap<String, (usize, Figures)>;

/// Vector registers, bytes of shared memory, instructions; and what of registers is kept elsewhere.
#[derive(Clone, Copy, Default)]
struct Figures {
    registers: u64,
    shared: u64,
    instructions: u64,
    /// Scalar registers that are kept in vector registers.
    spilled: u64,
    in_memory: u64,
}

impl Figures {
    fn of(compiled: &Compiled) -> Self {
        let figure = |wanted: &str| {
            let found = compiled.figures.iter().find(|(name, _)| name == wanted);
            found.unwrap_or_else(|| panic!("no {wanted} in {:?}", compiled.figures)).1
        };
        let in_memory = ["Spilled VGPRs", "Scratch size"].map(figure);
        Self {
            registers: figure("VGPRs"),
            shared: figure("LDS size"),
            instructions: figure("Instructions"),
            spilled: figure("Spilled SGPRs"),
            in_memory: in_memory.iter().sum(),
        }
    }

    fn most(self, other: Self) -> Self {
        Self {
            registers: self.registers.max(other.registers),
            shared: self.shared.max(other.shared),
            instructions: self.instructions.max(other.instructions),
            spilled: self.spilled.max(other.spilled),
            in_memory: self.in_memory.max(other.in_memory),
        }
    }
}

/// The page whose table bounds the registers.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/compilers.md");

/// The rows of a table as the page has them.
fn rows(table: &Table) -> String {
    let mut text = String::new();
    for (shader, (variants, most)) in table {
        let Figures { registers, spilled, shared, instructions, .. } = most;
        let instructions = match instructions {
            ..10_000 => instructions.to_string(),
            _ => format!("{},{:03}", instructions / 1000, instructions % 1000),
        };
        text += &format!(
            "| `{shader}` | {variants} | {registers} | {spilled} | {shared} | {instructions} |
"
        );
    }
    text
}

/// The vector registers that the page allows a shader, and the scalar ones that it may keep in those.
fn allowed(page: &str, shader: &str) -> Option<[u64; 2]> {
    let row = page.lines().find(|line| line.starts_with(&format!("| `{shader}` |")))?;
    let number = |column| row.split('|').nth(column)?.trim().parse().ok();
    Some([number(3)?, number(4)?])
}

/// In a process with both drivers.
#[test]
#[ignore = "run by `cards_compile_every_pipeline`, in an environment of its own"]
fn compile_all() {
    let instance = Instance::new(Validation::Off).expect("Vulkan");
    let devices = instance.devices().expect("devices");
    let mut cpu = devices.iter().find(|report| report.is_cpu()).expect("a CPU driver").clone();
    let card = devices.iter().find(|report| !report.is_cpu()).expect("a card's driver");
    assert_eq!(
        (cpu.machine, card.machine),
        (Machine::Cpu, Machine::Gpu),
        "what they are laid out for"
    );
    cpu.machine = Machine::Gpu;
    let device = Device::open(&instance, cpu).expect("a device");
    device.only_describe();
    // Nothing is drawn that would tell them.
    let rules = PointRules { limit_px: 250.0, draws_off_screen: false };
    device.point_rules.set(rules).expect("not yet probed");
    let (light, settings) = (crate::common::with_halo(DVec3::Y), settings());
    let made: Vec<bool> = settings.par_iter().map(|some| make(&device, some, &light)).collect();
    assert!(
        made[..2 * OTHERS.len()].iter().all(|is_made| *is_made),
        "{:?}",
        &settings[..2 * OTHERS.len()]
    );
    let made = made.iter().filter(|is_made| **is_made).count();
    println!("{made} of {} settings have a plan; {}", settings.len(), card.summary());

    let mut table = Table::new();
    let mut spilled = Vec::new();
    for compiled in device.pipelines_compiled_for(card).expect("every pipeline is made") {
        let figures = Figures::of(&compiled);
        let (variants, most) = table.entry(compiled.shader.into()).or_default();
        (*variants, *most) = (*variants + 1, most.most(figures));
        if figures.in_memory > 0 {
            spilled.push(format!("{} with {:?}", compiled.shader, compiled.constants));
        }
    }
    print!("{}", rows(&table));
    // The control: there is something to compile, by every way that a frame is drawn.
    for shader in ["composite.comp", "drops.frag", "glints.comp", "sum_logs.comp", "simulate.comp"]
    {
        assert!(table.contains_key(shader), "{shader} was not made");
    }
    assert!(spilled.is_empty(), "registers spill to memory: {spilled:#?}");
    let page = std::fs::read_to_string(PAGE).expect("docs/compilers.md");
    if std::env::var_os("RAINDROPS_WRITE_COMPILED").is_some() {
        let (head, rest) = page.split_once("|---|---|---|---|---|---|\n").expect("a table");
        let after = rest.split_once("\n\n").map_or("", |(_, after)| after);
        let text = format!("{head}|---|---|---|---|---|---|\n{}\n{after}", rows(&table));
        std::fs::write(PAGE, text).expect("the page is written");
    } else if page.contains(&card.driver_info) && card.name.contains(FAMILY) {
        for (shader, (_, most)) in &table {
            let allowed = allowed(&page, shader);
            let found = [most.registers, most.spilled];
            assert!(
                allowed.is_some_and(|allowed| found[0] <= allowed[0] && found[1] <= allowed[1]),
                "{shader} takes {found:?} registers, docs/compilers.md allows {allowed:?}: mend it, or write the table anew \
                 by RAINDROPS_WRITE_COMPILED=1"
            );
        }
    } else {
        println!(
            "registers are not held against docs/compilers.md: that is of another driver or card than {}",
            card.summary()
        );
    }
}

#[test]
fn cards_compile_every_pipeline() {
    let driver = |name: &str| format!("/usr/share/vulkan/icd.d/{name}_icd.x86_64.json");
    let drivers = [driver("lvp"), driver("radeon")];
    if let Some(missing) = drivers.iter().find(|path| !Path::new(path).exists()) {
        let without = std::env::var_os("RAINDROPS_TEST_WITHOUT_RADV").is_some();
        assert!(
            without,
            "there is no {missing}; Debian's and Ubuntu's mesa-vulkan-drivers has it, elsewhere RAINDROPS_TEST_WITHOUT_RADV=1 \
             leaves this test out"
        );
        eprintln!("not compiled for cards: there is no {missing}");
        return;
    }
    let family = std::env::var("RAINDROPS_TEST_FAMILY").unwrap_or_else(|_| FAMILY.into());
    let ran = Command::new(std::env::current_exe().expect("this test"))
        .args(["--ignored", "--exact", "vendors::compile_all", "--nocapture"])
        .env("VK_DRIVER_FILES", drivers.join(":"))
        .env("RADV_FORCE_FAMILY", family)
        .output()
        .expect("this test starts");
    let said = String::from_utf8_lossy(&ran.stdout);
    println!("{said}");
    assert!(ran.status.success(), "{said}\n{}", String::from_utf8_lossy(&ran.stderr));
    assert!(said.contains("1 passed"), "it ran: {said}");
}
