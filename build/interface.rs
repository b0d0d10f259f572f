//! What shaders and Rust share besides constants, read from the shaders and written for Rust: numbers of bindings and of
//! specialization constants, set by set; structures, member for member; sizes of workgroups.
//!
//! `build.rs` writes it, and fails where shaders of one set do not agree. `tests/house/abi.rs` holds it against the sources again.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use spirq::constant::Constant;
use spirq::prelude::*;
use spirq::ty::{ScalarType, StructType, VectorType};

use crate::glsl::{self, Glsl};

/// Shaders that are compiled a second time: file, suffix of the constant, macro that is defined.
const VARIANTS: &[(&str, &str, &str)] = &[
    ("bin_starts.comp", "_CELLS", "CELLS"),
    ("sort_clusters.comp", "_CELLS", "CELLS"),
    ("gather.comp", "_CELLS", "CELLS"),
    ("gather.comp", "_SHELTER", "SHELTER"),
    ("gather.comp", "_CELLS_SHELTER", "CELLS_SHELTER"),
    ("sky.comp", "_MEDIUM", "MEDIUM"),
    ("sky.comp", "_BEFORE", "BEFORE"),
    ("sky.comp", "_MEDIUM_BEFORE", "MEDIUM_BEFORE"),
    ("sky.comp", "_MEDIUM_SHELTER", "MEDIUM_SHELTER"),
    ("sky.comp", "_MEDIUM_BEFORE_SHELTER", "MEDIUM_BEFORE_SHELTER"),
    ("large.comp", "_CELLS", "CELLS"),
    ("composite.comp", "_DISORDERED", "DISORDERED"),
    ("composite.comp", "_CROWDED", "CROWDED"),
    ("composite.comp", "_LONG", "LONG"),
    ("glints.comp", "_SHARED", "SHARED"),
    ("composite.comp", "_FEW", "FEW"),
    ("drops.frag", "_CLOSED_FORM", "BY_CLOSED_FORM"),
    ("drops.frag", "_RADIAL", "DEVIATION_TABLE"),
    ("drops.frag", "_PICTURE", "BY_PICTURE"),
    ("drops.frag", "_STAGE", "STAGE"),
    ("motion_depth.frag", "_NUMBER", "NUMBER"),
    ("output.frag", "_BUFFER", "RADIANCE_IN_BUFFER"),
    ("output.frag", "_TEXELS", "RADIANCE_IN_TEXELS"),
    ("pane_cells.comp", "_STARTS", "STARTS"),
    ("pane_cells.comp", "_FILL", "FILL"),
    ("pane_cells.comp", "_ORDER", "ORDER"),
    ("pane_find.comp", "_COARSE", "COARSE"),
    ("pane_looks.comp", "_MEAN", "MEAN"),
    ("pane_looks.comp", "_TABLE", "TABLE"),
    ("pane_rays.comp", "_BLURRED", "BLURRED"),
    ("renew_map.comp", "_CUBE", "CUBE"),
    ("tone_map.frag", "_BUFFER", "RADIANCE_IN_BUFFER"),
    ("tone_map.frag", "_TEXELS", "RADIANCE_IN_TEXELS"),
];

/// Names that variants of a shader give to one number, of which a pass fills that of the variant it takes.
const ALTERNATIVES: &[&[&str]] =
    &[&["RADIANCE_IMAGE", "RADIANCE", "RADIANCE_TEXELS"], &["MASK", "TABLE"]];

/// Structures that Rust writes or reads, or whose size it needs. A shader may declare the first members alone.
const STRUCTURES: &[&str] = &[
    "BackgroundPush",
    "Constants",
    "Counters",
    "FlatLightPush",
    "Found",
    "Frame",
    "HeightsPush",
    "Known",
    "KnownCluster",
    "Large",
    "LargeShape",
    "LogSumsPush",
    "Motion",
    "MotionDepthPush",
    "Pane",
    "PaneCap",
    "PaneCellsPush",
    "PaneLook",
    "Part",
    "ParticlesPush",
    "Placed",
    "PlacedPush",
    "Population",
    "RainClass",
    "RainField",
    "RainTables",
    "RenewalPush",
    "Shelter",
    "Slab",
    "Source",
    "Totals",
    "Work",
];

/// A shader's file, the suffix of its variant and the macro of that.
pub struct Variant {
    pub file: String,
    pub suffix: &'static str,
    pub define: Option<&'static str>,
}

impl Variant {
    /// The name of its constant in Rust.
    pub fn constant(&self) -> String {
        self.file.replace('.', "_").to_uppercase() + self.suffix
    }

    /// What its descriptor set `number` is called: the first of a stage of the tile frame is that of all of them.
    fn set(&self, number: u32) -> &str {
        match self.own_set() {
            "tiles" | "composite" | "background" | "splat_table" if number == 0 => "tile_frame",
            own => own,
        }
    }

    /// What the set is called that it shares with few others.
    fn own_set(&self) -> &str {
        match (self.file.as_str(), self.define) {
            ("sky.comp", Some("BEFORE" | "MEDIUM_BEFORE" | "MEDIUM_BEFORE_SHELTER")) => {
                "background"
            }
            (
                "sky.comp"
                | "rays.comp"
                | "glints.comp"
                | "composite.comp"
                | "order_lists.comp"
                | "lines.comp"
                | "streak_layer_light.comp"
                | "tiles_to_draw.comp",
                _,
            ) => "composite",
            (
                "cells.comp" | "clusters.comp" | "bin_starts.comp" | "sort_clusters.comp"
                | "gather.comp" | "large.comp" | "big.comp" | "blocks.comp",
                _,
            ) => "tiles",
            ("far_glints.comp" | "bow.comp", _) => "glints",
            ("compact_counts.comp", _) => "compact",
            ("drops_point.vert" | "drops_quad.vert", _) => "drops",
            ("log_luminance.comp" | "sum_logs.comp", _) => "tone_map",
            (
                "pane_dry.comp" | "pane_find.comp" | "pane_looks.comp" | "pane_rays.comp"
                | "pane_logs.comp",
                _,
            ) => "pane",
            (file, _) => file.split('.').next().unwrap_or(file),
        }
    }
}

/// Every shader of a folder with its variants.
pub fn variants(folder: &Path) -> std::io::Result<Vec<Variant>> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.sort();
    let names = files.iter().filter(|path| glsl::kind(path).is_some());
    let names = names.filter_map(|path| path.file_name()?.to_str());
    let of = |name: &str| {
        let others = VARIANTS.iter().filter(|(file, ..)| *file == name);
        let others = others.map(|(_, suffix, define)| (*suffix, Some(*define)));
        let file = name.to_string();
        let all: Vec<_> = std::iter::once(("", None)).chain(others).collect();
        all.into_iter().map(move |(suffix, define)| Variant { file: file.clone(), suffix, define })
    };
    Ok(names.flat_map(of).collect())
}

/// The interface of one descriptor set: the names of its bindings and constants in its shaders, with their numbers.
#[derive(Default)]
struct Set {
    slots: BTreeMap<String, (u32, &'static str)>,
    constants: BTreeMap<String, u32>,
}

/// Structures by their names, and how many bytes from one to the next they are apart in arrays.
type Structures = BTreeMap<String, (StructType, usize)>;

/// What was read from all shaders.
#[derive(Default)]
pub struct Interface {
    /// A constant has one number in all shaders.
    constants: BTreeMap<String, u32>,
    sets: BTreeMap<String, Set>,
    structures: Structures,
    groups: BTreeMap<String, Vec<u32>>,
}

impl Interface {
    /// Compiles the shaders of `glsl`'s folder, unoptimised, and reads them.
    ///
    /// # Errors
    /// What the compiler says; where shaders do not agree, which and on what.
    pub fn read(glsl: &Glsl, variants: &[Variant]) -> Result<Self, String> {
        let mut interface = Self::default();
        for variant in variants {
            let words = glsl.compile_with_names(&variant.file, variant.define)?;
            interface.add(variant, words).map_err(|problem| {
                format!("glsl/{} {}: {problem}", variant.file, variant.define.unwrap_or_default())
            })?;
        }
        for (name, set) in &interface.sets {
            let slots = set.slots.iter().map(|(slot, (number, _))| (slot, *number));
            let constants = set.constants.iter().map(|(constant, number)| (constant, *number));
            apart(slots).and_then(|()| apart(constants)).map_err(|e| format!("set {name}: {e}"))?;
        }
        Ok(interface)
    }

    fn add(&mut self, variant: &Variant, words: Vec<u32>) -> Result<(), String> {
        let words = without_operations(&words);
        let read = |all| {
            let entries = ReflectConfig::new().spv(words.as_slice()).ref_all_rscs(all).reflect();
            entries.map_err(|error| error.to_string())
        };
        let (declared, used) = (read(true)?, read(false)?);
        for (entry, used) in declared.iter().zip(&used) {
            for variable in &entry.vars {
                match variable {
                    // A buffer may be declared in an include and not be used. (Of images no use is found where they are
                    // handed to functions.)
                    Variable::Descriptor { ty: Type::Struct(_), .. }
                        if !used.vars.contains(variable) => {}
                    Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                        gather(&mut self.structures, ty)?;
                        // Members of a block without a name of its own stand for themselves.
                        let name = match ty {
                            Type::Struct(block) => block.name.as_deref(),
                            _ => name.as_deref(),
                        };
                        // `XByFour` is X, four words at a time.
                        let name = name.map(|name| name.strip_suffix("ByFour").unwrap_or(name));
                        let slot = (desc_bind.bind(), kind_of(desc_ty)?);
                        let set = self.sets.entry(variant.set(desc_bind.set()).into()).or_default();
                        same(&mut set.slots, name.unwrap_or_default(), slot)?;
                    }
                    Variable::PushConstant { ty, .. } => gather(&mut self.structures, ty)?,
                    Variable::SpecConstant { name: Some(name), spec_id, .. } => {
                        let set = self.sets.entry(variant.own_set().into()).or_default();
                        same(&mut set.constants, name, *spec_id)?;
                        same(&mut self.constants, name, *spec_id)?;
                    }
                    _ => {}
                }
            }
            for mode in &entry.exec_modes {
                let literal = |operand: &Constant| match operand.value {
                    ConstantValue::U32(value) => Some(value),
                    _ => None,
                };
                let size: Vec<u32> = mode.operands.iter().filter_map(literal).collect();
                if size.len() == 3 {
                    self.groups.insert(variant.constant(), size);
                }
            }
        }
        Ok(())
    }

    /// Bindings and constants of each set, and sizes of workgroups, in Rust.
    pub fn sets(&self) -> String {
        let mut out = String::new();
        for (name, Set { slots, .. }) in self.sets.iter().filter(|(_, set)| !set.slots.is_empty()) {
            let _ = writeln!(out, "/// Bindings of set `{name}`.\npub mod {name} {{");
            for (slot, (number, kind)) in slots {
                let _ = writeln!(
                    out,
                    "    pub const {slot}: crate::gpu::Slot = \
                     crate::gpu::Slot::new({number}, crate::gpu::Binding::{kind});"
                );
            }
            out += "}\n";
        }
        out += "/// Numbers of specialization constants.\npub mod constant {\n";
        for (constant, number) in &self.constants {
            let _ = writeln!(out, "    pub const {constant}: u32 = {number};");
        }
        out += "}\n";
        out += "/// Invocations of a workgroup along each axis.\npub mod group {\n";
        for (shader, size) in &self.groups {
            let _ = writeln!(out, "    pub const {shader}: [u32; 3] = {size:?};");
        }
        out + "}\n"
    }

    /// The structures, in Rust.
    ///
    /// # Errors
    /// The structure that has a hole, or a member that Rust has no type for; one that no shader has.
    pub fn structures(&self) -> Result<String, String> {
        let mut out = String::new();
        for name in STRUCTURES {
            let (structure, apart) =
                self.structures.get(*name).ok_or(format!("no shader has {name}"))?;
            let _ = writeln!(
                out,
                "/// `{name}` of the shaders, whose comments tell what its members are.\n\
                 #[repr(C)]\n\
                 #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n\
                 #[allow(missing_docs)]\n\
                 pub struct {name} {{"
            );
            let mut end = 0;
            for member in &structure.members {
                let member_name = member.name.as_deref().unwrap_or_default();
                let of = |problem: &str| format!("{name}.{member_name}: {problem}");
                let Some((rust, bytes)) = rust_type(&member.ty).map_err(|e| of(&e))? else {
                    break; // as many as there are, at the end
                };
                if member.offset != Some(end) {
                    return Err(of("there is a hole before it"));
                }
                end += bytes;
                let raw = if member_name == "box" { "r#" } else { "" };
                let _ = writeln!(out, "    pub {raw}{member_name}: {rust},");
            }
            if *apart > end {
                let _ = writeln!(out, "    pub unused: [u32; {}],", (apart - end) / 4);
            }
            let _ = writeln!(
                out,
                "}}\nimpl Default for {name} {{\n    fn default() -> Self {{\n        \
                 bytemuck::Zeroable::zeroed()\n    }}\n}}"
            );
        }
        Ok(out)
    }
}

/// SPIR-V in which operations on specialization constants are zeros: their values are of no concern here, and the crate
/// knows not all of them.
fn without_operations(words: &[u32]) -> Vec<u32> {
    const HEADER: usize = 5;
    const SPEC_CONSTANT_OP: u32 = 52;
    const CONSTANT_NULL: u32 = 46;
    let mut out = words[..HEADER].to_vec();
    let mut rest = &words[HEADER..];
    while let Some(first) = rest.first() {
        let (instruction, others) = rest.split_at((first >> 16) as usize);
        match first & 0xffff {
            SPEC_CONSTANT_OP => {
                out.extend([3 << 16 | CONSTANT_NULL, instruction[1], instruction[2]])
            }
            _ => out.extend(instruction),
        }
        rest = others;
    }
    out
}

/// Enters a name's number, or fails if it has another already.
fn same<T: PartialEq + Copy + std::fmt::Debug>(
    known: &mut BTreeMap<String, T>,
    name: &str,
    number: T,
) -> Result<(), String> {
    let constant = screaming(name);
    let before = *known.entry(constant).or_insert(number);
    if before == number {
        return Ok(());
    }
    Err(format!("{name} is {number:?}, and {before:?} in another shader"))
}

/// Fails if two names have one number and are no alternatives.
fn apart<'a>(names: impl Iterator<Item = (&'a String, u32)>) -> Result<(), String> {
    let mut by_number: BTreeMap<u32, BTreeSet<&str>> = BTreeMap::new();
    for (name, number) in names {
        by_number.entry(number).or_default().insert(name);
    }
    for (number, names) in by_number {
        let allowed = |all: &&[&str]| names.iter().all(|name| all.contains(name));
        if names.len() > 1 && !ALTERNATIVES.iter().any(allowed) {
            return Err(format!("{names:?} are all {number}"));
        }
    }
    Ok(())
}

/// `DropOrder`, `sky_texels` and `RAYS_PX` as names of constants.
fn screaming(name: &str) -> String {
    let mut out = String::new();
    let mut before_is_lower = false;
    for letter in name.chars() {
        if letter.is_uppercase() && before_is_lower {
            out.push('_');
        }
        before_is_lower = letter.is_lowercase();
        out.extend(letter.to_uppercase());
    }
    out
}

fn kind_of(kind: &DescriptorType) -> Result<&'static str, String> {
    Ok(match kind {
        DescriptorType::CombinedImageSampler() => "COMBINED_IMAGE_SAMPLER",
        DescriptorType::StorageImage(_) => "STORAGE_IMAGE",
        DescriptorType::UniformTexelBuffer() => "UNIFORM_TEXEL_BUFFER",
        DescriptorType::UniformBuffer() => "UNIFORM_BUFFER",
        DescriptorType::StorageBuffer(_) => "STORAGE_BUFFER",
        other => return Err(format!("no pass binds {other:?}")),
    })
}

/// Collects the structures within a type.
fn gather(known: &mut Structures, ty: &Type) -> Result<(), String> {
    match ty {
        Type::Array(array) => {
            gather(known, &array.element_ty)?;
            if let Type::Struct(StructType { name: Some(name), .. }) = &*array.element_ty
                && let Some((_, apart)) = known.get_mut(name)
            {
                *apart = array.stride.unwrap_or(0).max(*apart);
            }
            Ok(())
        }
        Type::Struct(structure) => {
            for member in &structure.members {
                gather(known, &member.ty)?;
            }
            let name = structure.name.clone().unwrap_or_default();
            if !STRUCTURES.contains(&name.as_str()) {
                return Ok(());
            }
            let (before, _) = known.entry(name.clone()).or_insert_with(|| (structure.clone(), 0));
            let layout = |of: &StructType| -> Vec<_> {
                let member = |m: &spirq::ty::StructMember| (m.name.clone(), m.offset, m.ty.clone());
                of.members.iter().map(member).collect()
            };
            let (old, new) = (layout(before), layout(structure));
            if old.iter().zip(&new).any(|(old, new)| old != new) {
                return Err(format!("another {name} than in a shader before"));
            }
            if new.len() > old.len() {
                *before = structure.clone();
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// A type in Rust and its bytes; none if it has as many elements as there are.
fn rust_type(ty: &Type) -> Result<Option<(String, usize)>, String> {
    let scalar = |scalar: &ScalarType| match scalar {
        ScalarType::Float { bits: 32 } => Ok("f32"),
        ScalarType::Integer { bits: 32, is_signed: false } => Ok("u32"),
        ScalarType::Integer { bits: 32, is_signed: true } => Ok("i32"),
        other => Err(format!("no type for {other}")),
    };
    Ok(Some(match ty {
        Type::Scalar(of) => (scalar(of)?.into(), 4),
        Type::Vector(VectorType { scalar_ty, nscalar }) => {
            (format!("[{}; {nscalar}]", scalar(scalar_ty)?), 4 * *nscalar as usize)
        }
        Type::Array(array) => {
            let Some(count) = array.nelement else { return Ok(None) };
            let (of, bytes) = rust_type(&array.element_ty)?.ok_or("an array without end")?;
            let apart = array.stride.unwrap_or(bytes);
            if apart != bytes && !matches!(*array.element_ty, Type::Struct(_)) {
                return Err("its elements have holes between them".into());
            }
            (format!("[{of}; {count}]"), apart * count as usize)
        }
        Type::Struct(structure) => {
            let name = structure.name.clone().unwrap_or_default();
            (name, structure.nbyte().ok_or("a structure without end")?)
        }
        other => return Err(format!("no type for {other:?}")),
    }))
}
