//! What contacts remember, kept in step with the neighbour list: a contact that is listed before and
//! after a rebuild keeps its memory.

use super::friction::{Memory, Parameters};

/// Memories and parameters in the order of the neighbour list. Reused from build to build.
#[derive(Debug, Default)]
pub struct History {
    /// Of each listed pair of grains.
    pub pairs: Vec<Memory>,
    /// Of each grain near each wall.
    pub by_wall: Vec<Vec<Memory>>,
    /// Of each grain near the punch.
    pub by_punch: Vec<Memory>,
    /// Parameters of each listed pair of grains.
    pub parameters: Vec<Parameters>,
    aside: Aside,
}

/// The lists and memories before a rebuild.
#[derive(Debug, Default)]
struct Aside {
    start: Vec<u32>,
    other: Vec<u32>,
    pairs: Vec<Memory>,
    by_wall: Vec<(Vec<u32>, Vec<Memory>)>,
    by_punch: (Vec<u32>, Vec<Memory>),
}

impl History {
    /// Before a rebuild: keeps what is remembered, and for whom.
    pub fn set_aside(
        &mut self,
        start: &[u32],
        other: &[u32],
        by_wall: &[Vec<u32>],
        by_punch: &[u32],
    ) {
        let aside = &mut self.aside;
        copy(&mut aside.start, start);
        copy(&mut aside.other, other);
        std::mem::swap(&mut aside.pairs, &mut self.pairs);
        aside.by_wall.resize_with(by_wall.len(), Default::default);
        self.by_wall.resize_with(by_wall.len(), Default::default);
        for ((aside, ids), memories) in aside.by_wall.iter_mut().zip(by_wall).zip(&mut self.by_wall)
        {
            copy(&mut aside.0, ids);
            std::mem::swap(&mut aside.1, memories);
        }
        copy(&mut aside.by_punch.0, by_punch);
        std::mem::swap(&mut aside.by_punch.1, &mut self.by_punch);
    }

    /// After a rebuild: hands each memory to its pair in the new list.
    pub fn take_over(
        &mut self,
        start: &[u32],
        other: &[u32],
        by_wall: &[Vec<u32>],
        by_punch: &[u32],
    ) {
        let aside = &self.aside;
        self.pairs.clear();
        for (i, row) in start.windows(2).enumerate() {
            let before = match aside.start.get(i..i + 2) {
                Some(row) => row[0] as usize..row[1] as usize,
                None => 0..0,
            };
            let (old, memories) = (&aside.other[before.clone()], &aside.pairs[before]);
            for id in &other[row[0] as usize..row[1] as usize] {
                let found = old.iter().position(|old| old == id);
                self.pairs
                    .push(found.map_or(Memory::default(), |at| memories[at]));
            }
        }
        self.by_wall.resize_with(by_wall.len(), Default::default);
        for (index, (ids, memories)) in by_wall.iter().zip(&mut self.by_wall).enumerate() {
            match aside.by_wall.get(index) {
                Some(old) => of_flat_body(old, ids, memories),
                None => of_flat_body(&Default::default(), ids, memories),
            }
        }
        of_flat_body(&aside.by_punch, by_punch, &mut self.by_punch);
    }
}

/// Ids in rising order, old and new.
fn of_flat_body(old: &(Vec<u32>, Vec<Memory>), ids: &[u32], memories: &mut Vec<Memory>) {
    memories.clear();
    memories.extend(ids.iter().map(|id| match old.0.binary_search(id) {
        Ok(at) => old.1[at],
        Err(_) => Memory::default(),
    }));
}

fn copy(to: &mut Vec<u32>, from: &[u32]) {
    to.clear();
    to.extend_from_slice(from);
}
