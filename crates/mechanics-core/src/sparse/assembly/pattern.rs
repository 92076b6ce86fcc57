//! The slots of a growing pattern.

use crate::sparse::BlockPattern;
use std::sync::Arc;

/// The new number of a slot that is dropped.
const DROPPED: u32 = u32::MAX;

/// How slots are numbered anew.
#[derive(Debug)]
pub(super) struct Renumbering {
    /// The new number of every old slot; nobody asks for that of a slot that is dropped.
    pub(super) new_slot: Vec<u32>,
    /// The old number of every new slot.
    pub(super) old_slot: Vec<u32>,
}

/// Which slot stores which block, while blocks come and go: those of a [`BlockPattern`] in its order, then added
/// ones in the order they were asked for, and how many contributions each slot has.
#[derive(Debug)]
pub(super) struct SlotIndex {
    pattern: Arc<BlockPattern>,
    /// Blocks not in the pattern yet, by (column, row).
    added: Vec<Added>,
    /// Contributions per slot.
    uses: Vec<u32>,
    /// Off-diagonal slots without contributions.
    stale: usize,
}

#[derive(Clone, Copy, Debug)]
struct Added {
    column: u32,
    row: u32,
    slot: u32,
}

impl SlotIndex {
    /// The diagonal blocks of `columns` columns.
    pub(super) fn new(columns: usize) -> Self {
        let rows = (0..columns as u32).collect();
        let pattern = Arc::new(valid((0..=columns).collect(), rows));
        Self { pattern, added: Vec::new(), uses: vec![0; columns], stale: 0 }
    }

    pub(super) fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// The number of slots, added ones included.
    pub(super) fn slots(&self) -> usize {
        self.uses.len()
    }

    /// The number of off-diagonal slots without contributions.
    pub(super) fn stale(&self) -> usize {
        self.stale
    }

    /// The slots of `blocks`, which are (column, row) pairs that ascend strictly; missing ones are added.
    pub(super) fn slots_of(&mut self, blocks: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
        let mut fresh = Vec::new();
        let mut slots = Vec::new();
        let mut known = self.added.iter().peekable();
        for (column, row) in blocks {
            let slot =
                self.pattern.slot(row as usize, column as usize).map(|slot| slot as u32).or_else(|| {
                    while known.next_if(|added| (added.column, added.row) < (column, row)).is_some() {}
                    known
                        .peek()
                        .filter(|added| (added.column, added.row) == (column, row))
                        .map(|added| added.slot)
                });
            slots.push(slot.unwrap_or_else(|| {
                let slot = self.uses.len() as u32;
                self.uses.push(0);
                fresh.push(Added { column, row, slot });
                slot
            }));
        }
        self.stale += fresh.len();
        if !fresh.is_empty() {
            self.added.append(&mut fresh);
            self.added.sort_by_key(|added| (added.column, added.row));
        }
        slots
    }

    /// Counts contributions.
    pub(super) fn retain(&mut self, slots: impl Iterator<Item = usize>) {
        for slot in slots {
            if self.uses[slot] == 0 && !self.is_diagonal(slot) {
                self.stale -= 1;
            }
            self.uses[slot] += 1;
        }
    }

    /// Discounts contributions.
    pub(super) fn release(&mut self, slots: impl Iterator<Item = usize>) {
        for slot in slots {
            self.uses[slot] -= 1;
            if self.uses[slot] == 0 && !self.is_diagonal(slot) {
                self.stale += 1;
            }
        }
    }

    /// Sorts added blocks in and drops stale ones if asked to. Answers how slots are numbered now, or nothing if
    /// the pattern stays.
    pub(super) fn rebuild(&mut self, stale_blocks: StaleBlocks) -> Option<Renumbering> {
        let drops = stale_blocks == StaleBlocks::Drop && self.stale > 0;
        if self.added.is_empty() && !drops {
            return None;
        }
        let columns = self.pattern.columns();
        let mut new_slot = vec![DROPPED; self.slots()];
        let mut old_slot = Vec::with_capacity(self.slots());
        let mut rows = Vec::with_capacity(self.slots());
        let mut column_start = Vec::with_capacity(columns + 1);
        let mut added = self.added.iter().peekable();
        for column in 0..columns {
            column_start.push(rows.len());
            let mut push = |row: u32, slot: usize| {
                if self.uses[slot] > 0 || row as usize == column || !drops {
                    new_slot[slot] = rows.len() as u32;
                    rows.push(row);
                    old_slot.push(slot as u32);
                }
            };
            for slot in self.pattern.column(column) {
                let row = self.pattern.rows()[slot];
                while let Some(new) = added.next_if(|new| new.column as usize == column && new.row < row) {
                    push(new.row, new.slot as usize);
                }
                push(row, slot);
            }
            while let Some(new) = added.next_if(|new| new.column as usize == column) {
                push(new.row, new.slot as usize);
            }
        }
        column_start.push(rows.len());
        self.pattern = Arc::new(valid(column_start, rows));
        self.added.clear();
        self.uses = old_slot.iter().map(|&slot| self.uses[slot as usize]).collect();
        if drops {
            self.stale = 0;
        }
        Some(Renumbering { new_slot, old_slot })
    }

    fn is_diagonal(&self, slot: usize) -> bool {
        let row = self.pattern.rows().get(slot);
        row.is_some_and(|&row| self.pattern.column_start()[row as usize] == slot)
    }
}

/// What [`SlotIndex::rebuild`] does with blocks that have no contributions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StaleBlocks {
    Keep,
    Drop,
}

fn valid(column_start: Vec<usize>, rows: Vec<u32>) -> BlockPattern {
    match BlockPattern::new(column_start, rows) {
        Ok(pattern) => pattern,
        Err(error) => unreachable!("rows were pushed in order, diagonal first: {error}"),
    }
}
