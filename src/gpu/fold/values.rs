//! Which ids have one value, whatever an invocation does.

use std::collections::HashMap;

use spirv::Op;

use crate::gpu::words::{computed, head, op};

/// What is known of an id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// No instruction that gives it was reached yet.
    Unknown,
    /// 32 bits, or 0 and 1 of a truth value.
    Is(u32),
    Varies,
}
pub(super) use Value::{Is, Unknown, Varies};

/// What is known of each id, and the constants that are put among the module's.
pub(super) struct Values {
    pub(super) of: Vec<Value>,
    /// Types of 32 bits and of truth values; whether the latter.
    pub(super) scalars: HashMap<u32, bool>,
    /// Types of what instructions gave that have one value now.
    pub(super) found: Vec<(u32, u32)>,
}

impl Values {
    pub(super) fn of(globals: &[&[u32]], bound: u32) -> Self {
        let mut values =
            Self { of: vec![Varies; bound as usize], scalars: HashMap::new(), found: Vec::new() };
        for instruction in globals {
            match (op(instruction), &instruction[1..]) {
                (Op::TypeBool, [id]) => _ = values.scalars.insert(*id, true),
                (Op::TypeInt, [id, 32, _]) | (Op::TypeFloat, [id, 32]) => {
                    values.scalars.insert(*id, false);
                }
                (Op::ConstantTrue, [_, id]) => values.of[*id as usize] = Is(1),
                (Op::ConstantFalse, [_, id]) => values.of[*id as usize] = Is(0),
                (Op::Constant, [of, id, value]) if values.scalars.contains_key(of) => {
                    values.of[*id as usize] = Is(*value);
                }
                _ => {}
            }
        }
        values
    }

    // A literal among the operands may be taken for an id; what such an instruction gives varies.
    pub(super) fn get(&self, id: u32) -> Value {
        self.of.get(id as usize).copied().unwrap_or(Varies)
    }

    /// Takes a value in, beside what is known; whether that is news.
    pub(super) fn meet(&mut self, id: u32, value: Value) -> bool {
        let known = self.of[id as usize];
        let now = match (known, value) {
            (Unknown, value) => value,
            (Is(a), Is(b)) if a == b => known,
            (known, Unknown) => known,
            _ => Varies,
        };
        self.of[id as usize] = now;
        now != known
    }

    /// What an instruction gives that is no phi.
    pub(super) fn computed(&self, instruction: &[u32]) -> Value {
        if !self.scalars.contains_key(&instruction[1]) {
            return Varies;
        }
        let operands = &instruction[3..];
        let value = |number: usize| self.get(operands[number]);
        match op(instruction) {
            Op::CopyObject => return value(0),
            Op::Select => match value(0) {
                Is(which) => return value(if which != 0 { 1 } else { 2 }),
                not_known => return not_known,
            },
            // One side decides.
            Op::LogicalAnd if [value(0), value(1)].contains(&Is(0)) => return Is(0),
            Op::LogicalOr if [value(0), value(1)].contains(&Is(1)) => return Is(1),
            _ => {}
        }
        // More operands are not all ids.
        if operands.len() > 2 {
            return Varies;
        }
        let known: Vec<Value> = operands.iter().map(|operand| self.get(*operand)).collect();
        let constants: Option<Vec<u32>> = known
            .iter()
            .map(|value| if let Is(bits) = value { Some(*bits) } else { None })
            .collect();
        match constants {
            Some(constants) => computed(op(instruction), &constants).map_or(Varies, Is),
            None if known.contains(&Varies) => Varies,
            None => Unknown,
        }
    }

    /// Declarations of what was found to be constant.
    pub(super) fn constants(&self) -> impl Iterator<Item = u32> {
        self.found.iter().flat_map(|(of, id)| {
            let value = if let Is(value) = self.get(*id) { value } else { 0 };
            match (self.scalars.get(of), value) {
                (Some(true), 0) => vec![head(Op::ConstantFalse, 3), *of, *id],
                (Some(true), _) => vec![head(Op::ConstantTrue, 3), *of, *id],
                _ => vec![head(Op::Constant, 4), *of, *id, value],
            }
        })
    }
}
