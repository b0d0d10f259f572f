//! SPIR-V with its specialization constants given.
//!
//! Drivers do this themselves when a pipeline is made. But SwiftShader does not compute what depends on such constants
//! alone (`OpSpecConstantOp`, such as `MOTION != 0u`): it compiles both sides of each `if`, runs both, and so takes 4.4
//! times as long for `composite`. With plain constants in their place its optimizer removes what nothing asked for.

use std::collections::{HashMap, HashSet};

use spirv::{Decoration, Op};

use super::Specialization;

/// Words before the first instruction.
const HEADER: usize = 5;

/// The module with `values` in place of its specialization constants, and the results in place of what is computed
/// from them. A constant that is not given keeps its default. `words`: valid SPIR-V; its constants have 32 bits.
pub(super) fn specialize(words: &[u32], values: Specialization<'_>) -> Vec<u32> {
    let given: HashMap<u32, u32> = values.iter().map(|[number, value]| (*number, *value)).collect();
    let (mut numbers, mut bools, mut known) = (HashMap::new(), HashSet::new(), HashMap::new());
    let (mut made, mut rest) = (words[..HEADER].to_vec(), &words[HEADER..]);
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        rest = after;
        let value_of = |id: &u32, default| {
            let number = numbers.get(id);
            number.and_then(|number| given.get(number)).copied().unwrap_or(default)
        };
        // Of a constant its type, itself, and its value.
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

/// The first word of an instruction of so many.
fn head(op: Op, words: u32) -> u32 {
    words << 16 | op as u32
}

/// What an operation makes of constants; `None` for one that no shader here has.
fn computed(op: Op, operands: &[u32]) -> Option<u32> {
    Some(match (op, operands) {
        (Op::IAdd, [a, b]) => a.wrapping_add(*b),
        (Op::ISub, [a, b]) => a.wrapping_sub(*b),
        (Op::UDiv, [a, b]) => a.checked_div(*b)?,
        (Op::IEqual, [a, b]) => u32::from(a == b),
        (Op::INotEqual, [a, b]) => u32::from(a != b),
        (Op::UGreaterThan, [a, b]) => u32::from(a > b),
        (Op::LogicalNot, [a]) => u32::from(*a == 0),
        (Op::LogicalAnd, [a, b]) => a & b,
        (Op::LogicalOr, [a, b]) => a | b,
        (Op::Select, [which, a, b]) => *if *which != 0 { a } else { b },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use spirq::ReflectConfig;

    use super::*;
    use crate::gpu::shaders;

    #[test]
    fn nothing_is_left_of_any_shader() {
        for shader in shaders::ALL {
            let made = specialize(shader.words(), &[]);
            let mut rest = &made[HEADER..];
            while let Some(first) = rest.first() {
                let op = Op::from_u32(first & 0xffff).expect("an operation");
                let of = (shader.name, shader.define);
                assert!(!format!("{op:?}").starts_with("SpecConstant"), "{op:?} in {of:?}");
                rest = &rest[(first >> 16) as usize..];
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
}
