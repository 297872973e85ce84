//! What is remembered at work: the vector and the walks that test it, values, and the bit rows of the second channel.

use crate::answers::{Status, Value};
use crate::cells::set_bit;
use crate::checker::{Checker, DIRTY};
use crate::names::{Reason, Request};
use crate::records::*;
use crate::tables::{Int, Uint, Word};

// What a slot (the first three) or a waiting place holds.
pub const EMPTY: Uint = 0;
pub const RUNNING: Uint = 1;
pub const STOPPING: Uint = 2;
pub const WAITING: Uint = 3;
pub const CLEARING: Uint = 4;
/// In the cell of a phase stands so many times the number of the step that put it there above it.
pub const SINCE: Uint = 8;

/// A request, and its record.
#[derive(Clone, Copy)]
pub struct Subject<'t> {
    pub id: Request,
    pub index: Int,
    pub row: &'t RequestRow,
}

impl Subject<'_> {
    /// Where the phase of a slot or place stands; slot `instances` is the waiting place.
    pub fn phase_at(&self, slot: Int) -> Int {
        self.row.slots().wrapping_add(self.index).wrapping_add(slot)
    }

    pub fn place(&self) -> Int {
        self.row.instances()
    }
}

impl<'t> Checker<'t> {
    // ---- the state vector and the diagrams ----

    pub(crate) fn subject(&self, index: Int) -> Result<Subject<'t>, Status> {
        let id = *at(&Request::ALL, index)?;
        Ok(Subject { id, index, row: self.tables.at(&self.tables.requests, index)? })
    }

    /// Add to one entry, and remember the rules to look at.
    #[inline]
    fn bump(&mut self, index: Int, delta: Uint) -> Result<&'t EntryRow, Status> {
        let row = self.tables.at(&self.tables.entries, index)?;
        let cell = at_mut(&mut self.vector, index)?;
        cell.set(cell.get()?.wrapping_add(delta));
        if row.rules() != row.rules_end() {
            for rule in self.tables.range(&self.tables.lists, row.rules(), row.rules_end())? {
                set_bit(&mut self.dirty, rule.word())?;
            }
            self.agenda |= DIRTY;
        }
        Ok(row)
    }

    /// Add to an entry and to the sums it is part of; a sum is part of no sum.
    #[inline]
    pub(crate) fn add(&mut self, index: Int, delta: Uint) -> Result<(), Status> {
        let row = self.bump(index, delta)?;
        for sum in self.tables.range(&self.tables.sums, row.sums(), row.sums_end())? {
            self.bump(sum.entry(), (sum.factor() as Uint).wrapping_mul(delta))?;
        }
        Ok(())
    }

    pub(crate) fn put(&mut self, index: Int, value: Int) -> Result<(), Status> {
        if index < 0 {
            return Ok(());
        }
        let old = at(&self.vector, index)?.get()?;
        if old == value as Uint {
            return Ok(());
        }
        self.add(index, (value as Uint).wrapping_sub(old))
    }

    /// The first action on the path from a node, if there is one. Children stand after their parents.
    #[inline]
    pub(crate) fn walk(&self, mut index: Int) -> Result<Option<(Int, &'t NodeRow)>, Status> {
        while index != NONE {
            let node = self.tables.at(&self.tables.nodes, index)?;
            if node.code() < 0 {
                return Ok(Some((index, node)));
            }
            let now = at(&self.vector, node.code())?.get()?;
            let next = if now as Int <= node.bound() { node.low() } else { node.high() };
            if next <= index && next != NONE {
                return Err(Status::FaultPath);
            }
            index = next;
        }
        Ok(None)
    }

    /// Whether a predicate or condition holds: its path says `agree`.
    pub(crate) fn agrees(&self, predicate: Int) -> Result<bool, Status> {
        Ok(predicate == ALWAYS || self.walk(predicate)?.is_some())
    }

    /// Collect the actions on the path from a node, none of which is done before the path has ended.
    pub(crate) fn collect(&mut self, root: Int) -> Result<usize, Status> {
        let mut found: usize = 0;
        let mut next = root;
        while let Some((index, node)) = self.walk(next)? {
            next = node.low();
            if next <= index && next != NONE {
                return Err(Status::FaultPath);
            }
            *self.path.get_mut(found).ok_or(Status::FaultPath)? = index as Word;
            found = found.wrapping_add(1);
        }
        Ok(found)
    }

    pub(crate) fn step(&self, number: usize) -> Result<&'t NodeRow, Status> {
        let index = *self.path.get(number).ok_or(Status::FaultPath)?;
        self.tables.at(&self.tables.nodes, index as Int)
    }

    // ---- values ----

    /// A value that is remembered.
    pub(crate) fn kept(&self, index: Int) -> Result<Value, Status> {
        let value = *at(&self.values, index)?;
        if value == at(&self.inverses, index)?.inverse() {
            Ok(value)
        } else {
            Err(Status::FaultState)
        }
    }

    pub(crate) fn keep(&mut self, index: Int, value: Value) -> Result<(), Status> {
        *at_mut(&mut self.values, index)? = value;
        *at_mut(&mut self.inverses, index)? = value.inverse();
        Ok(())
    }

    // ---- the second channel: bit rows, and counts of active slots that the diagrams never read ----

    /// Whether a request with which this one must never be active is active.
    #[inline]
    pub(crate) fn in_conflict(&self, row: &RequestRow) -> Result<bool, Status> {
        let mut met = 0;
        for block in self.tables.range(&self.tables.conflicts, row.conflicts(), row.conflicts_end())? {
            met |= at(&self.active, block.block())?.get()? & block.mask() as Uint;
        }
        Ok(met & 0xffff != 0)
    }

    /// Count a slot of a request in or out, and keep its bit.
    #[inline]
    pub(crate) fn occupy(&mut self, request: Int, comes: bool) -> Result<(), Status> {
        let held = at_mut(&mut self.held, request)?;
        let active = at_mut(&mut self.active, request >> 4)?;
        let bit = (1 as Uint).wrapping_shl(request as u32 & 15);
        let (before, bits) = (held.get()?, active.get()?);
        let after = if comes { before.checked_add(1) } else { before.checked_sub(1) }.ok_or(Status::FaultChannels)?;
        held.set(after);
        active.set(if after != 0 { bits | bit } else { bits & !bit });
        Ok(())
    }
}

pub fn reason(index: Int) -> Result<Reason, Status> {
    at(&Reason::ALL, index).copied()
}
