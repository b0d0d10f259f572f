//! Which ways through a function are taken, and the function without the others.

use std::collections::{HashMap, HashSet};

use spirv::Op;

use super::result;
use super::values::{Is, Unknown, Values, Varies};
use crate::gpu::words::{head, op};

/// A part of a function that is run from its first instruction to its last, a branch.
struct Block<'a> {
    label: u32,
    instructions: Vec<&'a [u32]>,
}

impl Block<'_> {
    fn last(&self) -> &[u32] {
        self.instructions.last().copied().unwrap_or(&[])
    }

    /// The merge block and the continue target of the loop that begins here.
    fn loop_of(&self) -> Option<[u32; 2]> {
        let merge = self.instructions.iter().find(|i| op(i) == Op::LoopMerge)?;
        Some([merge[1], merge[2]])
    }
}

/// A function's blocks, and which ways through them are taken.
pub(super) struct Flow<'a> {
    /// What comes before the first block, and after the last.
    ends: [Vec<&'a [u32]>; 2],
    blocks: Vec<Block<'a>>,
    places: HashMap<u32, usize>,
    reached: Vec<bool>,
    /// From a block's label to another's.
    taken: HashSet<(u32, u32)>,
}

impl<'a> Flow<'a> {
    /// Finds what a function reaches, and the values of its ids; none for a loop that is left by its continue construct alone.
    pub(super) fn found(function: &[&'a [u32]], values: &mut Values) -> Option<Self> {
        let mut flow = Self {
            ends: [Vec::new(), Vec::new()],
            blocks: Vec::new(),
            places: HashMap::new(),
            reached: Vec::new(),
            taken: HashSet::new(),
        };
        for instruction in function {
            match (op(instruction), flow.blocks.last_mut()) {
                (Op::Label, _) => {
                    flow.places.insert(instruction[1], flow.blocks.len());
                    flow.blocks.push(Block { label: instruction[1], instructions: Vec::new() });
                }
                (Op::FunctionEnd, _) => flow.ends[1].push(instruction),
                (_, None) => flow.ends[0].push(instruction),
                (_, Some(block)) => {
                    if let Some(id) = result(instruction) {
                        values.of[id as usize] = Unknown;
                    }
                    block.instructions.push(instruction);
                }
            }
        }
        flow.reached = vec![false; flow.blocks.len()];
        if let Some(first) = flow.reached.first_mut() {
            *first = true;
        }
        while flow.goes_on(values) {}
        flow.has_its_loops().then_some(flow)
    }

    /// Goes once through the blocks that are reached; whether anything was news.
    fn goes_on(&mut self, values: &mut Values) -> bool {
        let mut is_news = false;
        for place in 0..self.blocks.len() {
            if !self.reached[place] {
                continue;
            }
            let block = &self.blocks[place];
            for instruction in &block.instructions {
                let Some(id) = result(instruction) else { continue };
                if op(instruction) != Op::Phi {
                    is_news |= values.meet(id, values.computed(instruction));
                    continue;
                }
                let is_scalar = values.scalars.contains_key(&instruction[1]);
                for way in instruction[3..].chunks_exact(2) {
                    if self.taken.contains(&(way[1], block.label)) {
                        let value = if is_scalar { values.get(way[0]) } else { Varies };
                        is_news |= values.meet(id, value);
                    }
                }
            }
            for to in self.ways(place, values) {
                is_news |= self.taken.insert((self.blocks[place].label, to));
                self.reached[self.places[&to]] = true;
            }
        }
        is_news
    }

    /// Labels to which a block may branch.
    fn ways(&self, place: usize, values: &Values) -> Vec<u32> {
        let last = self.blocks[place].last();
        match (op(last), self.decided(place, values)) {
            (_, Some(way)) => vec![way],
            (Op::Branch, _) => vec![last[1]],
            (Op::BranchConditional, _) if values.get(last[1]) == Unknown => Vec::new(),
            (Op::BranchConditional, _) => vec![last[2], last[3]],
            (Op::Switch, _) if values.get(last[1]) == Unknown => Vec::new(),
            (Op::Switch, _) => {
                let cases = last[3..].chunks_exact(2).map(|case| case[1]);
                std::iter::once(last[2]).chain(cases).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The one way of a branch on what is known. A loop's header keeps both, as does a branch back to one.
    fn decided(&self, place: usize, values: &Values) -> Option<u32> {
        let block = &self.blocks[place];
        let last = block.last();
        let is_back = |to: u32| self.places[&to] <= place;
        match (op(last), values.get(*last.get(1)?)) {
            (Op::BranchConditional, Is(value)) => {
                let is_loop = block.loop_of().is_some() || is_back(last[2]) || is_back(last[3]);
                (!is_loop).then(|| last[if value != 0 { 2 } else { 3 }])
            }
            (Op::Switch, Is(value)) => {
                let case = last[3..].chunks_exact(2).find(|case| case[0] == value);
                Some(case.map_or(last[2], |case| case[1]))
            }
            _ => None,
        }
    }

    /// Whether each loop whose continue target is reached goes back to its header.
    fn has_its_loops(&self) -> bool {
        let mut loops =
            self.blocks.iter().zip(&self.reached).filter(|(_, is_reached)| **is_reached);
        loops.all(|(header, _)| match header.loop_of() {
            Some([_, next]) if self.reached[self.places[&next]] => {
                let place = self.places[&header.label];
                let goes_back =
                    |(from, to): &(u32, u32)| *to == header.label && self.places[from] >= place;
                self.taken.iter().any(goes_back)
            }
            _ => true,
        })
    }

    /// Stubs: blocks that are not reached but named by an instruction that stays. The header of the loop that one continues;
    /// none for a merge block.
    fn stubs(&self, values: &Values) -> HashMap<u32, Option<u32>> {
        let mut stubs = HashMap::new();
        for (place, block) in
            self.blocks.iter().enumerate().filter(|(place, _)| self.reached[*place])
        {
            let is_decided =
                op(block.last()) == Op::BranchConditional && self.decided(place, values).is_some();
            for instruction in &block.instructions {
                match op(instruction) {
                    Op::LoopMerge => {
                        stubs.entry(instruction[1]).or_insert(None);
                        stubs.insert(instruction[2], Some(block.label));
                    }
                    Op::SelectionMerge if !is_decided => {
                        stubs.entry(instruction[1]).or_insert(None);
                    }
                    _ => {}
                }
            }
        }
        stubs.retain(|label, _| !self.reached[self.places[label]]);
        stubs
    }

    /// Writes what is reached. `gone` gets the ids that are not given any more, or among the module's constants.
    pub(super) fn write(&self, values: &mut Values, made: &mut Vec<u32>, gone: &mut HashSet<u32>) {
        made.extend(self.ends[0].iter().copied().flatten());
        let stubs = self.stubs(values);
        for (place, block) in self.blocks.iter().enumerate() {
            if self.reached[place] {
                made.extend([head(Op::Label, 2), block.label]);
                self.write_block(place, &stubs, values, made, gone);
                continue;
            }
            gone.extend(block.instructions.iter().filter_map(|instruction| result(instruction)));
            match stubs.get(&block.label) {
                None => _ = gone.insert(block.label),
                Some(None) => {
                    made.extend([head(Op::Label, 2), block.label, head(Op::Unreachable, 1)])
                }
                Some(Some(header)) => {
                    made.extend([head(Op::Label, 2), block.label, head(Op::Branch, 2), *header])
                }
            }
        }
        made.extend(self.ends[1].iter().copied().flatten());
    }

    fn write_block(
        &self,
        place: usize,
        stubs: &HashMap<u32, Option<u32>>,
        values: &mut Values,
        made: &mut Vec<u32>,
        gone: &mut HashSet<u32>,
    ) {
        let block = &self.blocks[place];
        let decided = self.decided(place, values);
        for instruction in &block.instructions {
            let constant = result(instruction).filter(|id| matches!(values.get(*id), Is(_)));
            match (op(instruction), constant, decided) {
                (_, Some(id), _) => {
                    values.found.push((instruction[1], id));
                    gone.insert(id);
                }
                (Op::Phi, ..) => made.extend(self.phi(block, instruction, stubs)),
                (Op::SelectionMerge, _, Some(_)) if op(block.last()) == Op::BranchConditional => {}
                (Op::BranchConditional, _, Some(way)) => made.extend([head(Op::Branch, 2), way]),
                (Op::Switch, _, Some(way)) => {
                    made.extend([head(Op::Switch, 3), instruction[1], way])
                }
                _ => made.extend(*instruction),
            }
        }
    }

    /// A phi of the ways that are taken. From a stub comes what comes from before the loop: it is never run.
    fn phi(
        &self,
        block: &Block,
        instruction: &[u32],
        stubs: &HashMap<u32, Option<u32>>,
    ) -> Vec<u32> {
        let is_taken = |way: &&[u32]| self.taken.contains(&(way[1], block.label));
        let mut ways: Vec<u32> =
            instruction[3..].chunks_exact(2).filter(is_taken).flatten().copied().collect();
        for (label, header) in stubs {
            if *header == Some(block.label) && !ways.is_empty() {
                ways.extend([ways[0], *label]);
            }
        }
        let mut made = vec![head(Op::Phi, 3 + ways.len() as u32), instruction[1], instruction[2]];
        made.extend(ways);
        made
    }
}
