//! SPIR-V with its specialization constants given, and with what the device promises declared.
//!
//! Drivers do this themselves when a pipeline is made. But SwiftShader does not compute what depends on such constants
//! alone (`OpSpecConstantOp`, such as `MOTION != 0u`): it compiles both sides of each `if`, runs both, and so takes 4.4
//! times as long for `composite`. With plain constants in their place its optimizer removes what nothing asked for.

use std::collections::{HashMap, HashSet};

use spirv::{Capability, Decoration, ExecutionMode, Op};

use super::sets::constant;
use super::words::{HEADER, computed, head, instructions, op};
use super::{Promises, Reconvergence, Specialization};

/// The execution mode that the crate does not know yet.
const MAXIMALLY_RECONVERGES: u32 = 6023;
const EXTENSION: &[u8] = b"SPV_KHR_maximal_reconvergence\0\0\0";

/// The module with `values` in place of its specialization constants, and the results in place of what is computed
/// from them; what `promises` say is declared. A constant that is not given keeps its default. `words`: valid SPIR-V; its
/// constants have 32 bits.
pub(super) fn specialize(
    words: &[u32],
    values: Specialization<'_>,
    promises: Promises,
) -> Vec<u32> {
    let mut given: HashMap<u32, u32> =
        values.iter().map(|[number, value]| (*number, *value)).collect();
    given.insert(constant::RECONVERGES, (promises.reconvergence != Reconvergence::Open).into());
    given.insert(constant::LOSES_LEFT, promises.loses_left.into());
    let (mut numbers, mut bools, mut known) = (HashMap::new(), HashSet::new(), HashMap::new());
    let (mut made, all) = (words[..HEADER].to_vec(), instructions(words));
    let mut declared = Declared::of(promises, has_subgroups(&all));
    let mut aliases = Aliases::default();
    for instruction in all {
        let first = instruction[0];
        declared.before(instruction, &mut made);
        let value_of = |id: &u32, default| {
            let number = numbers.get(id);
            number.and_then(|number| given.get(number)).copied().unwrap_or(default)
        };
        // A constant gives its type, its id and its value.
        let constant = match (Op::from_u32(first & 0xffff), &instruction[1..]) {
            (Some(Op::Decorate), [id, decoration, number])
                if *decoration == Decoration::SpecId as u32 =>
            {
                numbers.insert(*id, *number);
                continue;
            }
            (Some(Op::TypeBool), [id]) => {
                bools.insert(*id);
                None
            }
            (Some(Op::ConstantFalse), [of, id]) => Some((of, id, 0)),
            (Some(Op::ConstantTrue), [of, id]) => Some((of, id, 1)),
            (Some(Op::Constant), [of, id, value]) => Some((of, id, *value)),
            (Some(Op::SpecConstantFalse), [of, id]) => Some((of, id, value_of(id, 0))),
            (Some(Op::SpecConstantTrue), [of, id]) => Some((of, id, value_of(id, 1))),
            (Some(Op::SpecConstant), [of, id, default]) => Some((of, id, value_of(id, *default))),
            (Some(Op::SpecConstantOp), [of, id, op, operands @ ..]) => {
                let operands: Option<Vec<u32>> =
                    operands.iter().map(|operand| known.get(operand).copied()).collect();
                let value = operands.and_then(|operands| computed(Op::from_u32(*op)?, &operands));
                value.map(|value| (of, id, value))
            }
            _ => None,
        };
        let Some((of, id, value)) = constant else {
            // The size of a workgroup, whose members are given by now.
            let is_composite = first & 0xffff == Op::SpecConstantComposite as u32;
            let op = if is_composite { Op::ConstantComposite as u32 } else { first & 0xffff };
            made.push(first & 0xffff_0000 | op);
            made.extend(&instruction[1..]);
            aliases.after(instruction, &mut made);
            continue;
        };
        known.insert(*id, value);
        match (bools.contains(of), value) {
            (true, 0) => made.extend([head(Op::ConstantFalse, 3), *of, *id]),
            (true, _) => made.extend([head(Op::ConstantTrue, 3), *of, *id]),
            (false, _) => made.extend([head(Op::Constant, 4), *of, *id, value]),
        }
    }
    made
}

/// Variables that have one binding, such as `Nodes` and `NodesByFour`: the same memory, which GLSL has no word for.
#[derive(Default)]
struct Aliases {
    /// Set and binding of each variable, as far as they were told.
    places: HashMap<u32, [Option<u32>; 2]>,
    bound: HashMap<[u32; 2], u32>,
}

impl Aliases {
    /// Decorates both of two such variables after the instruction by which the second one has its place.
    fn after(&mut self, instruction: &[u32], made: &mut Vec<u32>) {
        let [_, id, decoration, number] = *instruction else { return };
        let which = match decoration {
            _ if op(instruction) != Op::Decorate => return,
            _ if decoration == Decoration::DescriptorSet as u32 => 0,
            _ if decoration == Decoration::Binding as u32 => 1,
            _ => return,
        };
        let place = self.places.entry(id).or_default();
        place[which] = Some(number);
        let [Some(set), Some(binding)] = *place else { return };
        if let Some(other) = self.bound.insert([set, binding], id) {
            for id in [other, id] {
                made.extend([head(Op::Decorate, 3), id, Decoration::Aliased as u32]);
            }
        }
    }
}

/// What is declared of a device's promises. SPIR-V has capabilities, then extensions, then entry points and their modes.
struct Declared {
    promises: Promises,
    /// Whether invocations of a subgroup speak with each other. To others the promise of reconvergence is of no use, and
    /// costs: rays through flattened drops took 1.8 times as long on an H200.
    has_subgroups: bool,
    /// Declarations that were put in: capabilities, extensions, modes.
    is_put: [bool; 3],
    entry: u32,
}

impl Declared {
    fn of(promises: Promises, has_subgroups: bool) -> Self {
        Self { promises, has_subgroups, is_put: [false; 3], entry: 0 }
    }

    /// Puts in what comes before an instruction.
    fn before(&mut self, instruction: &[u32], made: &mut Vec<u32>) {
        let op = Op::from_u32(instruction[0] & 0xffff);
        let rounds = self.promises.rounds_to_nearest;
        let reconverges =
            self.has_subgroups && self.promises.reconvergence == Reconvergence::Promised;
        let mut comes = |which: usize, is_here: bool, is_wanted: bool| {
            let is_first = is_here && !self.is_put[which];
            self.is_put[which] |= is_here;
            is_first && is_wanted
        };
        if comes(0, true, rounds) {
            made.extend([head(Op::Capability, 2), Capability::RoundingModeRTE as u32]);
        }
        if comes(1, op != Some(Op::Capability), reconverges) {
            let text =
                EXTENSION.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            made.push(head(Op::Extension, 1 + EXTENSION.len() as u32 / 4));
            made.extend(text);
        }
        if op == Some(Op::EntryPoint) {
            self.entry = instruction[2];
        } else if self.entry != 0 && comes(2, true, true) {
            let mode = ExecutionMode::RoundingModeRTE as u32;
            if rounds {
                made.extend([head(Op::ExecutionMode, 4), self.entry, mode, 32]);
            }
            if reconverges {
                made.extend([head(Op::ExecutionMode, 3), self.entry, MAXIMALLY_RECONVERGES]);
            }
        }
    }
}

/// Whether a module asks for one of the capabilities of subgroups, which come first in it.
fn has_subgroups(all: &[&[u32]]) -> bool {
    let of_subgroups = Capability::GroupNonUniform as u32..=Capability::GroupNonUniformQuad as u32;
    let mut asked = all.iter().take_while(|instruction| op(instruction) == Op::Capability);
    asked.any(|instruction| of_subgroups.contains(&instruction[1]))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use spirq::ReflectConfig;

    use super::*;
    use crate::gpu::shaders;

    const ALL: Promises = Promises {
        rounds_to_nearest: true,
        reconvergence: Reconvergence::Promised,
        loses_left: false,
    };

    /// The instructions, each with its operation.
    fn instructions(words: &[u32]) -> Vec<(Op, &[u32])> {
        let known = |i: &[u32]| Op::from_u32(i[0] & 0xffff).expect("an operation");
        super::instructions(words).into_iter().map(|i| (known(i), i)).collect()
    }

    #[test]
    fn nothing_is_left_of_any_shader() {
        for shader in shaders::ALL {
            let made = specialize(shader.words(), &[], Promises::default());
            for (op, _) in instructions(&made) {
                let of = (shader.name, shader.define);
                assert!(!format!("{op:?}").starts_with("SpecConstant"), "{op:?} in {of:?}");
            }
            // A reader of its own finds no number of a constant either.
            let mut reader = ReflectConfig::new();
            let read = reader.spv(made).ref_all_rscs(true).reflect().expect("SPIR-V");
            let vars = read.iter().flat_map(|entry| &entry.vars);
            assert!(
                vars.into_iter()
                    .all(|var| !matches!(var, spirq::var::Variable::SpecConstant { .. }))
            );
        }
    }

    #[test]
    fn what_a_device_promises_is_declared_where_spir_v_has_it() {
        let mut kinds = BTreeSet::new();
        for shader in shaders::ALL {
            let made = specialize(shader.words(), &[], ALL);
            // Capabilities, extensions, imports and the memory model, entry points, modes, the rest.
            let part = |op: &Op| match op {
                Op::Capability => 0,
                Op::Extension => 1,
                Op::ExtInstImport | Op::MemoryModel => 2,
                Op::EntryPoint => 3,
                Op::ExecutionMode | Op::ExecutionModeId => 4,
                _ => 5,
            };
            let all = instructions(&made);
            assert!(all.iter().map(|(op, _)| part(op)).is_sorted(), "{}", shader.name);
            let has = |op: Op, operands: &[u32]| {
                all.iter().filter(|(is, i)| *is == op && i[1..].ends_with(operands)).count()
            };
            assert_eq!(has(Op::Capability, &[4467]), 1, "RoundingModeRTE in {}", shader.name);
            assert_eq!(has(Op::ExecutionMode, &[4462, 32]), 1, "{}", shader.name);
            let speak = |(op, _): &(Op, _)| format!("{op:?}").starts_with("GroupNonUniform");
            let reconverges = usize::from(all.iter().any(speak));
            assert_eq!(has(Op::ExecutionMode, &[6023]), reconverges, "{}", shader.name);
            kinds.insert(reconverges);
            let bare = specialize(shader.words(), &[], Promises::default());
            let more = made.len() - bare.len();
            let of_subgroups = reconverges * (9 + 3);
            assert_eq!(
                more,
                2 + 4 + of_subgroups,
                "without promises nothing of it is in {}",
                shader.name
            );
        }
        assert_eq!(kinds.len(), 2, "shaders with subgroups, and without");
    }

    #[test]
    fn buffers_of_one_binding_are_aliased() {
        let mut found = BTreeSet::new();
        for shader in shaders::ALL {
            let made = specialize(shader.words(), &[], Promises::default());
            let of = |decoration: Decoration| {
                let all = instructions(&made).into_iter();
                let all = all.filter(|(op, i)| *op == Op::Decorate && i[2] == decoration as u32);
                all.map(|(_, i)| (i[1], i.get(3).copied())).collect::<HashMap<_, _>>()
            };
            let sets = of(Decoration::DescriptorSet);
            let aliased: BTreeSet<u32> = of(Decoration::Aliased).into_keys().collect();
            let mut places = HashMap::<_, BTreeSet<u32>>::new();
            for (id, binding) in of(Decoration::Binding) {
                places.entry((sets[&id], binding)).or_default().insert(id);
            }
            let shared = places.into_values().filter(|ids| ids.len() > 1).flatten();
            assert_eq!(aliased, shared.collect(), "{}", shader.name);
            found.extend((!aliased.is_empty()).then_some(shader.name));
        }
        assert!(found.contains("gather.comp") && !found.contains("sky.frag"), "{found:?}");
    }

    /// The blocks of a function, each with what it does for subgroups, and where it goes.
    #[derive(Default)]
    struct Blocks {
        operations: HashMap<u32, Vec<Op>>,
        next: HashMap<u32, Vec<u32>>,
        first: u32,
    }

    impl Blocks {
        /// The blocks of a shader that has one function; branches on constants are followed.
        fn of(words: &[u32]) -> Self {
            let (mut blocks, mut at, mut known) = (Self::default(), 0, HashMap::new());
            for (op, i) in instructions(words) {
                match op {
                    Op::ConstantTrue => drop(known.insert(i[2], 1)),
                    Op::ConstantFalse => drop(known.insert(i[2], 2)),
                    Op::Label => {
                        at = i[1];
                        blocks.first = if blocks.first == 0 { at } else { blocks.first };
                        blocks.next.insert(at, Vec::new());
                    }
                    Op::Branch => blocks.next.entry(at).or_default().push(i[1]),
                    Op::BranchConditional => {
                        let to = known.get(&i[1]).map_or(i[2..4].to_vec(), |one| vec![i[1 + one]]);
                        blocks.next.insert(at, to);
                    }
                    Op::Switch => {
                        let to = i[3..].chunks(2).filter_map(|pair| pair.get(1));
                        blocks.next.insert(at, to.chain([&i[2]]).copied().collect());
                    }
                    _ if format!("{op:?}").starts_with("GroupNonUniform") => {
                        blocks.operations.entry(at).or_default().push(op);
                    }
                    _ => (),
                }
            }
            blocks
        }

        /// All that may come after a block.
        fn after(&self, block: u32) -> BTreeSet<u32> {
            let (mut found, mut left) = (BTreeSet::new(), self.next[&block].clone());
            while let Some(at) = left.pop() {
                if found.insert(at) {
                    left.extend(&self.next[&at]);
                }
            }
            found
        }

        /// Why its subgroups need more than Vulkan promises, if they do: some take what one alone took in a branch, or
        /// work together in a loop in which a branch may part them.
        fn counts_on_more(&self) -> Option<&'static str> {
            let reached: BTreeSet<u32> =
                self.after(self.first).into_iter().chain([self.first]).collect();
            let ways_to = |block: u32| {
                let comes = |from: &&u32| self.next[*from].contains(&block);
                reached.iter().filter(comes).copied().collect::<Vec<_>>()
            };
            let works = |block: &u32| self.operations.contains_key(block);
            for block in reached.iter().filter(|block| works(block)) {
                let mut before = self.operations[block].clone();
                let mut at = *block;
                while let [from] = ways_to(at)[..]
                    && self.next[&from].len() == 1
                {
                    before.extend(self.operations.get(&from).into_iter().flatten());
                    at = from;
                }
                let takes = self.operations[block].contains(&Op::GroupNonUniformBroadcastFirst);
                if takes && !before.contains(&Op::GroupNonUniformElect) {
                    return Some("a branch");
                }
                let own = self.after(*block);
                let parts = reached.iter().filter(|branch| {
                    self.next[branch].len() > 1
                        && own.contains(branch)
                        && self.after(**branch).contains(block)
                });
                if parts.count() > 1 {
                    return Some("a loop");
                }
            }
            None
        }
    }

    #[test]
    fn without_a_promise_no_subgroup_counts_on_more() {
        let mut promised = BTreeSet::new();
        for shader in shaders::ALL {
            let of = |reconvergence| {
                let promises = Promises { reconvergence, ..Promises::default() };
                Blocks::of(&specialize(shader.words(), &[], promises)).counts_on_more()
            };
            assert_eq!(of(Reconvergence::Open), None, "{} {:?}", shader.name, shader.define);
            promised.extend(of(Reconvergence::Promised).map(|why| (shader.name, why)));
        }
        // The control: with it several do.
        for control in [("gather.comp", "a branch"), ("compact.comp", "a loop")] {
            assert!(promised.contains(&control), "{promised:?}");
        }
    }
}
