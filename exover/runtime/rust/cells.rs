//! Cells: what is remembered, compared with its complement before use; bits in them; and where arguments are remembered.

use crate::answers::Status;
use crate::records::{at, at_mut};
use crate::tables::{Int, Uint};

/// Where arguments are: nowhere, in the event or required launch, or in so many values from here on.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Args {
    Nothing,
    Given,
    Kept(Int),
}

/// What is remembered, and its complement.
#[derive(Clone, Copy)]
pub struct Cell {
    now: Uint,
    inverse: Uint,
}

impl Cell {
    pub const ZERO: Cell = Cell { now: 0, inverse: !0 };

    pub fn is_sound(&self) -> bool {
        self.now ^ self.inverse == Uint::MAX
    }

    #[inline]
    pub fn get(&self) -> Result<Uint, Status> {
        if self.is_sound() {
            Ok(self.now)
        } else {
            Err(Status::FaultState)
        }
    }

    #[inline]
    pub fn set(&mut self, value: Uint) {
        self.now = value;
        self.inverse = !value;
    }

    /// What either half says: for a faulty checker.
    pub fn either(&self) -> Uint {
        self.now | !self.inverse
    }

    /// What is remembered, right or wrong: for a faulty checker.
    pub fn claimed(&self) -> Uint {
        self.now
    }
}

// ---- bits, 32 to a cell ----

fn bit(index: Int) -> Uint {
    (1 as Uint).wrapping_shl(index as u32 & 31)
}

pub fn set_bit(bits: &mut [Cell], index: Int) -> Result<(), Status> {
    let cell = at_mut(bits, index >> 5)?;
    cell.set(cell.get()? | bit(index));
    Ok(())
}

pub fn clear_bit(bits: &mut [Cell], index: Int) -> Result<(), Status> {
    let cell = at_mut(bits, index >> 5)?;
    cell.set(cell.get()? & !bit(index));
    Ok(())
}

/// Whether either half of the cell says that the bit is set: for a faulty checker.
pub fn may_have_bit(bits: &[Cell], index: Int) -> bool {
    at(bits, index >> 5).is_ok_and(|cell| cell.either() & bit(index) != 0)
}

pub fn has_bit(bits: &[Cell], index: Int) -> Result<bool, Status> {
    Ok(at(bits, index >> 5)?.get()? & bit(index) != 0)
}

/// The least set bit from `index` on, if there is one.
pub fn next_bit(bits: &[Cell], mut index: Int, end: Int) -> Result<Option<Int>, Status> {
    while index < end {
        let left = at(bits, index >> 5)?.get()?.wrapping_shr(index as u32 & 31);
        if left != 0 {
            let found = index.wrapping_add(left.trailing_zeros() as Int);
            return Ok(if found < end { Some(found) } else { None });
        }
        index = (index | 31).wrapping_add(1);
    }
    Ok(None)
}
