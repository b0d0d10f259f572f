//! SPIR-V without what no invocation reaches.
//!
//! The shaders hold every model, and specialization constants choose one. All that a module holds goes through each pass of a
//! driver's compiler before the driver finds which branches are never taken: on llvmpipe the pipelines of a picture of one
//! drop take 2.3 to 2.7 s to make as they are, and 1.1 to 1.3 s without those branches.
//!
//! What is constant, and which blocks are reached, is found together, by sparse conditional constant propagation (Wegman and
//! Zadeck, *Constant propagation with conditional branches*, 1991). SPIR-V's structured control flow stays: a loop keeps its
//! header, and a merge block or continue target that a remaining instruction names stays as a stub.

mod flow;
mod values;

use std::collections::HashSet;

use spirv::Op;

use self::flow::Flow;
use self::values::Values;
use super::words::{HEADER, instructions, op};

/// The module without blocks that are never reached, and with constants in place of what has one value. `words`: valid SPIR-V
/// without debug lines, whose specialization constants are given.
pub(super) fn folded(words: &[u32]) -> Vec<u32> {
    let all = instructions(words);
    let begin = all.iter().position(|i| op(i) == Op::Function).unwrap_or(all.len());
    let (globals, rest) = all.split_at(begin);
    let mut values = Values::of(globals, words[3]);
    let (mut body, mut gone) = (Vec::new(), HashSet::new());
    for function in rest.split_inclusive(|i| op(i) == Op::FunctionEnd) {
        let Some(flow) = Flow::found(function, &mut values) else { return words.to_vec() };
        flow.write(&mut values, &mut body, &mut gone);
    }
    let mut made = words[..HEADER].to_vec();
    for instruction in globals {
        let names = matches!(op(instruction), Op::Name | Op::Decorate | Op::DecorateId);
        if !(names && gone.contains(&instruction[1])) {
            made.extend(*instruction);
        }
    }
    made.extend(values.constants());
    made.extend(body);
    made
}

/// The id that an instruction of a function gives.
fn result(instruction: &[u32]) -> Option<u32> {
    match op(instruction) {
        Op::Label => Some(instruction[1]),
        Op::Store
        | Op::CopyMemory
        | Op::ImageWrite
        | Op::AtomicStore
        | Op::ControlBarrier
        | Op::MemoryBarrier
        | Op::SelectionMerge
        | Op::LoopMerge
        | Op::Branch
        | Op::BranchConditional
        | Op::Switch
        | Op::Return
        | Op::ReturnValue
        | Op::Kill
        | Op::TerminateInvocation
        | Op::DemoteToHelperInvocation
        | Op::Unreachable
        | Op::Nop
        | Op::FunctionEnd => None,
        _ => instruction.get(2).copied(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::gpu::specialize::specialize;
    use crate::gpu::words::head;
    use crate::gpu::{Promises, Shader, shaders};

    /// Values for all specialization constants, which are under 64.
    fn with(shader: &Shader, value: u32) -> Vec<u32> {
        let values: Vec<[u32; 2]> = (0..64).map(|number| [number, value]).collect();
        specialize(shader.words(), &values, Promises::default())
    }

    /// Fails unless each branch has its block, each phi a way from each block that branches there, and each name its id.
    fn expect_whole(name: &str, words: &[u32]) {
        let all = instructions(words);
        let mut given: HashSet<u32> =
            all.iter().filter(|i| op(i) == Op::Label).map(|i| i[1]).collect();
        let (mut into, mut block) = (HashMap::<u32, HashSet<u32>>::new(), 0);
        for instruction in &all {
            let ways: Vec<u32> = match op(instruction) {
                Op::Label => {
                    block = instruction[1];
                    continue;
                }
                Op::Branch => vec![instruction[1]],
                Op::BranchConditional => vec![instruction[2], instruction[3]],
                Op::Switch => {
                    let cases = instruction[3..].chunks_exact(2).map(|case| case[1]);
                    std::iter::once(instruction[2]).chain(cases).collect()
                }
                Op::SelectionMerge => {
                    assert!(given.contains(&instruction[1]), "{name}: no merge block");
                    continue;
                }
                Op::LoopMerge => {
                    assert!(
                        instruction[1..3].iter().all(|id| given.contains(id)),
                        "{name}: no loop"
                    );
                    continue;
                }
                _ => continue,
            };
            for way in ways {
                assert!(given.contains(&way), "{name}: a branch to nothing");
                into.entry(way).or_default().insert(block);
            }
        }
        for instruction in &all {
            match op(instruction) {
                Op::Label => block = instruction[1],
                Op::Phi => {
                    let ways: HashSet<u32> =
                        instruction[3..].chunks_exact(2).map(|way| way[1]).collect();
                    assert_eq!(Some(&ways), into.get(&block), "{name}: a phi");
                }
                _ => {}
            }
        }
        // What is given is at one of two places, and nothing that stays asks for what is gone.
        let others = all.iter().filter(|i| !matches!(op(i), Op::Decorate | Op::Name));
        given.extend(others.flat_map(|i| i.iter().skip(1).take(2)));
        for instruction in all.iter().filter(|i| op(i) == Op::Decorate) {
            assert!(given.contains(&instruction[1]), "{name}: a decoration of nothing");
        }
    }

    #[test]
    fn every_shader_stays_whole() {
        for shader in shaders::ALL {
            for value in [0, 1, 2, 5] {
                let words = with(shader, value);
                let made = folded(&words);
                expect_whole(shader.name, &words);
                expect_whole(shader.name, &made);
                assert!(made.len() <= words.len(), "{}", shader.name);
                assert_eq!(folded(&made), made, "{}: twice", shader.name);
            }
        }
    }

    /// What one model alone needs is not in the pipelines of the others.
    #[test]
    fn branches_of_other_models_are_gone() {
        let composite = shaders::ALL.iter().find(|shader| shader.name == "composite.comp");
        let words = with(composite.expect("a shader"), 0);
        let made = folded(&words);
        assert!(2 * made.len() < words.len(), "{} of {} words", made.len(), words.len());
    }

    fn block(label: u32, instructions: &[&[u32]]) -> Vec<u32> {
        let mut made = vec![head(Op::Label, 2), label];
        made.extend(instructions.iter().copied().flatten());
        made
    }

    /// `if (c) { a } else { b }` with 1 and 2 of the two; the phi of what is stored, and whether both blocks are there.
    #[test]
    fn a_branch_on_what_is_known_has_one_way() {
        for (c, kept, gone) in [(Op::ConstantTrue, 21, 22), (Op::ConstantFalse, 22, 21)] {
            let mut words = vec![0x0723_0203, 0x1_0600, 0, 40, 0];
            words.extend([head(Op::TypeBool, 2), 1, head(Op::TypeInt, 4), 2, 32, 0]);
            words.extend([
                head(c, 3),
                1,
                3,
                head(Op::Constant, 4),
                2,
                4,
                1,
                head(Op::Constant, 4),
                2,
                5,
                2,
            ]);
            words.extend([head(Op::Variable, 4), 6, 7, 2]);
            words.extend([head(Op::Function, 5), 8, 9, 0, 10]);
            let branch =
                [head(Op::SelectionMerge, 3), 23, 0, head(Op::BranchConditional, 4), 3, 21, 22];
            let to_merge = [head(Op::Branch, 2), 23];
            let phi = [head(Op::Phi, 7), 2, 30, 4, 21, 5, 22];
            let end = [head(Op::Store, 3), 7, 30, head(Op::Return, 1)];
            words.extend(block(20, &[&branch]));
            words.extend(block(21, &[&to_merge]));
            words.extend(block(22, &[&to_merge]));
            words.extend(block(23, &[&phi, &end]));
            words.push(head(Op::FunctionEnd, 1));
            let made = folded(&words);
            expect_whole("two ways", &made);
            let all = instructions(&made);
            let has = |label: u32| all.iter().any(|i| op(i) == Op::Label && i[1] == label);
            assert!(has(kept) && !has(gone), "{c:?}");
            let value = if c == Op::ConstantTrue { 1 } else { 2 };
            assert!(all.contains(&&[head(Op::Constant, 4), 2, 30, value][..]), "{c:?}");
        }
    }
}
