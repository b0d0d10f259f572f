//! SPIR-V as words: its instructions, and what those of integers and truth values make of constants.

use spirv::Op;

/// Words before the first instruction.
pub(super) const HEADER: usize = 5;

/// The instructions of a module. The first word of each holds its operation and how many words it has.
pub(super) fn instructions(words: &[u32]) -> Vec<&[u32]> {
    let (mut all, mut rest) = (Vec::new(), &words[HEADER..]);
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        rest = after;
        all.push(instruction);
    }
    all
}

/// The operation of an instruction; `Nop` for one that the crate does not know.
pub(super) fn op(instruction: &[u32]) -> Op {
    Op::from_u32(instruction[0] & 0xffff).unwrap_or(Op::Nop)
}

/// The first word of an instruction of so many.
pub(super) fn head(op: Op, words: u32) -> u32 {
    words << 16 | op as u32
}

/// What an operation makes of constants of 32 bits and truth values; `None` for one that is not computed here.
pub(super) fn computed(op: Op, operands: &[u32]) -> Option<u32> {
    let signed = |value: u32| value as i32;
    Some(match (op, operands) {
        (Op::LogicalNot, [a]) => u32::from(*a == 0),
        (Op::Not, [a]) => !a,
        (Op::SNegate, [a]) => a.wrapping_neg(),
        (Op::IAdd, [a, b]) => a.wrapping_add(*b),
        (Op::ISub, [a, b]) => a.wrapping_sub(*b),
        (Op::IMul, [a, b]) => a.wrapping_mul(*b),
        (Op::UDiv, [a, b]) => a.checked_div(*b)?,
        (Op::LogicalAnd | Op::BitwiseAnd, [a, b]) => a & b,
        (Op::LogicalOr | Op::BitwiseOr, [a, b]) => a | b,
        (Op::IEqual | Op::LogicalEqual, [a, b]) => u32::from(a == b),
        (Op::INotEqual | Op::LogicalNotEqual, [a, b]) => u32::from(a != b),
        (Op::UGreaterThan, [a, b]) => u32::from(a > b),
        (Op::UGreaterThanEqual, [a, b]) => u32::from(a >= b),
        (Op::ULessThan, [a, b]) => u32::from(a < b),
        (Op::ULessThanEqual, [a, b]) => u32::from(a <= b),
        (Op::SGreaterThan, [a, b]) => u32::from(signed(*a) > signed(*b)),
        (Op::SGreaterThanEqual, [a, b]) => u32::from(signed(*a) >= signed(*b)),
        (Op::SLessThan, [a, b]) => u32::from(signed(*a) < signed(*b)),
        (Op::SLessThanEqual, [a, b]) => u32::from(signed(*a) <= signed(*b)),
        (Op::Select, [which, a, b]) => *if *which != 0 { a } else { b },
        _ => return None,
    })
}
