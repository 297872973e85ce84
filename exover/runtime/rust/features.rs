//! What values are worth: entries of arguments and readings, what slots count for, pasts, stocks, latches.

use crate::answers::{Status, Value};
use crate::cells::Args;
use crate::checker::Checker;
use crate::records::*;
use crate::state::{Subject, CLEARING, EMPTY, RUNNING, SINCE, STOPPING, WAITING};
use crate::tables::{Int, Uint, LATCHES};

impl<'t> Checker<'t> {
    // ---- values ----

    /// Put a value into the entry that tests of it read: of a real, twice the number of cuts below it, one more if it is
    /// a cut itself.
    fn measure(&mut self, gauge: &Gauge, value: Value) -> Result<(), Status> {
        if !gauge.real {
            return self.put(gauge.value, value.integer() as Int);
        }
        if gauge.rank < 0 {
            return Ok(());
        }
        range(&self.tables.reals, gauge.cuts, gauge.cuts_end)?;
        let (mut low, mut high) = (gauge.cuts, gauge.cuts_end);
        while low < high {
            let middle = low.wrapping_add(high.wrapping_sub(low) / 2);
            if self.tables.real(middle)? < value.real() {
                low = middle.wrapping_add(1);
            } else {
                high = middle;
            }
        }
        let is_cut = low < gauge.cuts_end && self.tables.real(low)? <= value.real();
        self.put(gauge.rank, low.wrapping_sub(gauge.cuts).wrapping_mul(2).wrapping_add(Int::from(is_cut)))
    }

    /// An argument.
    fn arg(&self, args: Args, number: Int) -> Result<Value, Status> {
        match args {
            Args::Nothing => Err(Status::FaultIndex),
            Args::Given => Ok(*at(&self.given, number)?),
            Args::Kept(first) => self.kept(first.wrapping_add(number)),
        }
    }

    /// What stands at a side of a comparison: parameter `k`, result `k - params`, or poster `-1 - k`.
    fn side(&self, k: Int, params: Int, args: Args) -> Result<f64, Status> {
        let value = if k < 0 {
            self.kept(raw(self.tables.at(&self.tables.variables, !k)?))?
        } else if k < params {
            self.arg(args, k)?
        } else {
            *at(&self.given, k.wrapping_sub(params))?
        };
        Ok(value.real())
    }

    /// Compare what can be: of the first `all` sides of a request, or posters.
    fn compare(&mut self, orders: (Int, Int), params: Int, all: Int, args: Args) -> Result<(), Status> {
        for order in self.tables.range(&self.tables.orders, orders.0, orders.1)? {
            if order.left() < all && order.right() < all {
                let (left, right) = (self.side(order.left(), params, args)?, self.side(order.right(), params, args)?);
                let sign = if left < right {
                    0
                } else if left > right {
                    2
                } else {
                    1
                };
                self.put(order.entry(), sign)?;
            }
        }
        Ok(())
    }

    /// Put arguments, and what is given as results, into the entries that tests of them read.
    #[inline]
    pub(crate) fn put_args(&mut self, row: &RequestRow, args: Args, results: bool) -> Result<(), Status> {
        let params = row.arity();
        let all = if results { row.params_end().wrapping_sub(row.params()) } else { params };
        if all == 0 || self.loaded == (args, results) {
            return Ok(());
        }
        self.loaded = (args, results);
        for k in 0..all {
            let param = self.tables.at(&self.tables.params, row.params().wrapping_add(k))?;
            let value = if k < params { self.arg(args, k)? } else { *at(&self.given, k.wrapping_sub(params))? };
            self.measure(&param.gauge(), value)?;
        }
        self.compare((row.orders(), row.orders_end()), params, all, args)
    }

    pub(crate) fn fits(&mut self, row: &RequestRow, predicate: Int, args: Args, results: bool) -> Result<bool, Status> {
        if predicate >= 0 {
            self.put_args(row, args, results)?;
        }
        self.agrees(predicate)
    }

    // ---- what slots and waiting places count for ----

    /// Where the arguments of a slot or place are.
    pub(crate) fn args_of(&self, row: &RequestRow, slot: Int) -> Args {
        match row.arity() {
            0 => Args::Nothing,
            arity => Args::Kept(row.values().wrapping_add(slot.wrapping_mul(arity))),
        }
    }

    /// Let a slot or place remember arguments, if they are not its own.
    pub(crate) fn remember(&mut self, row: &RequestRow, slot: Int, args: Args) -> Result<(), Status> {
        if let own @ Args::Kept(first) = self.args_of(row, slot) {
            if own != args {
                for k in 0..row.arity() {
                    let value = self.arg(args, k)?;
                    self.keep(first.wrapping_add(k), value)?;
                }
                self.loaded = (Args::Nothing, false);
            }
        }
        Ok(())
    }

    /// What a slot or place counts for in a feature.
    #[inline]
    fn count_for(&mut self, row: &RequestRow, slot: Int, feature: &FeatureRow) -> Result<Uint, Status> {
        if feature.slot() != NONE && feature.slot() != slot {
            return Ok(0);
        }
        if feature.predicate() == ALWAYS && feature.weight() < 0 {
            return Ok(1);
        }
        let args = self.args_of(row, slot);
        if !self.fits(row, feature.predicate(), args, false)? {
            return Ok(0);
        }
        if feature.weight() < 0 {
            return Ok(1);
        }
        Ok(self.arg(args, feature.weight())?.integer() as Uint)
    }

    /// Count what a slot or place holds in, or out of, every feature of its request.
    #[inline]
    pub(crate) fn tally(&mut self, row: &RequestRow, slot: Int, phase: Uint, comes: bool) -> Result<(), Status> {
        for feature in self.tables.range(&self.tables.features, row.features(), row.features_end())? {
            let entry = match phase {
                RUNNING => feature.running(),
                STOPPING => feature.stopping(),
                WAITING => feature.waiting(),
                CLEARING => feature.clearing(),
                _ => return Err(Status::FaultState),
            };
            if entry >= 0 {
                let weight = self.count_for(row, slot, feature)?;
                if weight != 0 {
                    self.add(entry, if comes { weight } else { weight.wrapping_neg() })?;
                }
            }
        }
        Ok(())
    }

    /// Count the slots out or in whose features read a poster.
    fn recount(&mut self, row: &VariableRow, comes: bool) -> Result<(), Status> {
        for request in self.tables.range(&self.tables.lists, row.refresh(), row.refresh_end())? {
            let subject = self.subject(request.word())?;
            for slot in 0..subject.place() {
                let phase = self.phase(subject, slot)?;
                if phase != EMPTY {
                    self.tally(subject.row, slot, phase, comes)?;
                }
            }
        }
        Ok(())
    }

    /// What a slot or place holds.
    #[inline]
    pub(crate) fn phase(&self, subject: Subject<'t>, slot: Int) -> Result<Uint, Status> {
        Ok(at(&self.phases, subject.phase_at(slot))?.get()? % SINCE)
    }

    // ---- variables, effects, stocks ----

    /// Let a poster, state or latch read a value.
    pub(crate) fn read(&mut self, row: &'t VariableRow, value: Value) -> Result<(), Status> {
        self.recount(row, false)?;
        self.measure(&row.gauge(), value)?;
        if row.raw() >= 0 {
            self.keep(raw(row), value)?;
            self.loaded = (Args::Nothing, false);
        }
        self.compare((row.orders(), row.orders_end()), 0, 0, Args::Nothing)?;
        self.recount(row, true)
    }

    fn read_integer(&mut self, variable: Int, value: Int) -> Result<(), Status> {
        let row = self.tables.at(&self.tables.variables, variable)?;
        self.read(row, Value::from(i64::from(value)))
    }

    /// Set the latches whose condition holds, and clear those that the success of a request clears.
    pub(crate) fn latch(&mut self, succeeded: Int) -> Result<(), Status> {
        for row in self.tables.range(&self.tables.latches, 0, LATCHES as Int)? {
            let is_set = self.agrees(row.condition())?;
            let resets = self.tables.range(&self.tables.lists, row.resets(), row.resets_end())?;
            if is_set || resets.iter().any(|request| request.word() == succeeded) {
                self.read_integer(row.variable(), Int::from(is_set))?;
            }
        }
        Ok(())
    }

    pub(crate) fn affect(&mut self, from: Int, to: Int) -> Result<(), Status> {
        for effect in self.tables.range(&self.tables.effects, from, to)? {
            if effect.kind() == SET {
                self.read_integer(effect.target(), effect.value())?;
                continue;
            }
            let row = self.tables.at(&self.tables.requests, effect.target())?;
            for past in self.tables.range(&self.tables.pasts, row.pasts(), row.pasts_end())? {
                self.put(past.entry(), 0)?;
            }
        }
        Ok(())
    }

    /// Take what a launch consumes.
    pub(crate) fn consume(&mut self, row: &RequestRow, args: Args) -> Result<(), Status> {
        for amount in self.tables.range(&self.tables.amounts, row.consumes(), row.produces())? {
            let stock = self.tables.at(&self.tables.stocks, amount.stock())?;
            if stock.entry() >= 0 && self.fits(row, amount.predicate(), args, false)? {
                self.add(stock.entry(), (amount.amount() as Uint).wrapping_neg())?;
            }
        }
        Ok(())
    }

    /// Give what a success produces, never above the capacity.
    pub(crate) fn produce(&mut self, row: &RequestRow, args: Args) -> Result<(), Status> {
        for amount in self.tables.range(&self.tables.amounts, row.produces(), row.produces_end())? {
            let stock = self.tables.at(&self.tables.stocks, amount.stock())?;
            if stock.entry() >= 0 && self.fits(row, amount.predicate(), args, false)? {
                let level = at(&self.vector, stock.entry())?.get()? as Int;
                let room = stock.capacity().wrapping_sub(level);
                self.add(stock.entry(), amount.amount().min(room) as Uint)?;
            }
        }
        Ok(())
    }
}
