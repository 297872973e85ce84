//! Decisions: what the diagrams say is done, but nothing is launched that the bit rows do not allow.

use crate::answers::{Action, Status, Value, Why};
use crate::cells::{clear_bit, has_bit, next_bit, set_bit, Args, Cell};
use crate::checker::{Checker, BROKEN, DIRTY, MARKED, PLACE};
use crate::names::Reason;
use crate::records::*;
use crate::state::{reason, Subject, CLEARING, EMPTY, RUNNING, SINCE, STOPPING, WAITING};
use crate::tables::{Int, Uint, LAUNCHES, REQUESTS, RULES};

/// Of what a newcomer comes: its launch rule, and the same if that starts it now.
#[derive(Clone, Copy)]
struct Cause {
    required: Option<Reason>,
    launch_rule: Option<Reason>,
}

impl<'t> Checker<'t> {
    // ---- slots and waiting places ----

    fn is_waiting(&self, subject: Subject<'t>) -> Result<bool, Status> {
        Ok(self.agenda >= PLACE && self.phase(subject, subject.place())? != EMPTY)
    }

    pub(crate) fn set_phase(&mut self, subject: Subject<'t>, slot: Int, phase: Uint) -> Result<(), Status> {
        let since = (self.steps as Uint).wrapping_mul(SINCE);
        at_mut(&mut self.phases, subject.phase_at(slot))?.set(since | phase);
        Ok(())
    }

    /// Let a slot or place hold something else: in this phase, these arguments.
    fn hold(&mut self, subject: Subject<'t>, slot: Int, next: Uint, args: Args) -> Result<(), Status> {
        let row = subject.row;
        let phase = self.phase(subject, slot)?;
        if slot == subject.place() {
            if phase == next && (next == EMPTY || self.args_of(row, slot) == args) {
                return Ok(());
            }
            match (phase, next) {
                (EMPTY, EMPTY) => {}
                (EMPTY, _) => self.agenda = self.agenda.wrapping_add(PLACE),
                (_, EMPTY) => self.agenda = self.agenda.wrapping_sub(PLACE),
                _ => {}
            }
            if next == EMPTY {
                clear_bit(&mut self.taken, subject.index)?;
            } else {
                set_bit(&mut self.taken, subject.index)?;
            }
        }
        if phase != EMPTY {
            self.tally(row, slot, phase, false)?;
        }
        self.set_phase(subject, slot, next)?;
        self.changed = true;
        if next == EMPTY {
            return Ok(());
        }
        self.remember(row, slot, args)?;
        self.tally(row, slot, next, true)
    }

    pub(crate) fn vacate(&mut self, subject: Subject<'t>, why: Why) -> Result<(), Status> {
        self.hold(subject, subject.place(), EMPTY, Args::Nothing)?;
        self.say(Action::Reject { request: Some(subject.id), why, launch_rule: self.origin(subject)? })
    }

    /// The launch rule that put there what waits at a request; none if it was asked for.
    fn origin(&self, subject: Subject<'t>) -> Result<Option<Reason>, Status> {
        if LAUNCHES == 0 {
            return Ok(None);
        }
        match at(&self.origins, subject.index)?.get()? {
            0 => Ok(None),
            number => reason((number as Int).wrapping_sub(1)).map(Some),
        }
    }

    pub(crate) fn kill(&mut self, subject: Subject<'t>, slot: Int, why: Why) -> Result<(), Status> {
        if self.phase(subject, slot)? != RUNNING {
            return Ok(());
        }
        self.hold(subject, slot, STOPPING, self.args_of(subject.row, slot))?;
        self.say(Action::Kill { request: subject.id, slot: slot as u32, why })
    }

    /// Kill what a node says: all slots of a request, or one slot of all.
    fn kill_target(&mut self, node: &NodeRow) -> Result<(), Status> {
        let why = Why::Rule(reason(node.bound())?);
        if node.high() >= 0 {
            let subject = self.subject(node.high())?;
            for slot in 0..subject.place() {
                self.kill(subject, slot, why)?;
            }
            return Ok(());
        }
        let target = !node.high();
        let (mut request, mut end): (Int, Int) = (0, REQUESTS as Int);
        while end.wrapping_sub(request) > 1 {
            let middle = request.wrapping_add(end) / 2;
            if self.tables.at(&self.tables.requests, middle)?.slots() <= target {
                request = middle;
            } else {
                end = middle;
            }
        }
        let subject = self.subject(request)?;
        self.kill(subject, target.wrapping_sub(subject.row.slots()), why)
    }

    // ---- decisions ----

    /// The diagrams say launch; nothing is launched unless the bit rows say so too.
    #[inline]
    fn launch(&mut self, subject: Subject<'t>, args: Args, cause: Cause) -> Result<(), Status> {
        let row = subject.row;
        let mut slot = 0;
        while self.phase(subject, slot)? != EMPTY {
            slot = slot.wrapping_add(1);
            if slot >= subject.place() {
                return Err(Status::FaultDecision);
            }
        }
        if self.in_conflict(row)? {
            return Err(Status::FaultChannels);
        }
        self.occupy(subject.index, true)?;
        if self.agenda >= PLACE {
            self.hold(subject, subject.place(), EMPTY, Args::Nothing)?;
        }
        self.remember(row, slot, args)?;
        self.set_phase(subject, slot, RUNNING)?;
        self.tally(row, slot, RUNNING, true)?;
        self.changed = true;
        self.consume(row, args)?;
        self.affect(row.on_launch(), row.on_ok())?;
        let Cause { required, launch_rule } = cause;
        self.say(Action::Launch { request: subject.id, slot: slot as u32, reason: required, launch_rule })
    }

    /// Whether a denial shows that a request of the bit row is active.
    #[inline]
    fn shows_conflict(&self, first: &NodeRow) -> Result<bool, Status> {
        let action = first.action();
        if !(REJECT..=CLEAR).contains(&action) {
            return Ok(false);
        }
        let denials = self.tables.at(&self.tables.reasons, first.bound())?.denials();
        Ok(denials == ALL_DENIALS || (denials == CLEARINGS && action == CLEAR))
    }

    /// The first action of the decision on a request.
    #[inline]
    fn decide(&mut self, subject: Subject<'t>, args: Args) -> Result<(Int, &'t NodeRow), Status> {
        self.put_args(subject.row, args, false)?;
        let (index, first) = self.walk(subject.row.decide())?.ok_or(Status::FaultDecision)?;
        if self.shows_conflict(first)? && !self.in_conflict(subject.row)? {
            return Err(Status::FaultChannels);
        }
        Ok((index, first))
    }

    /// Do what a decision says that is no rejection; what the newcomer waits for, if it does.
    #[inline]
    fn carry_out(
        &mut self,
        subject: Subject<'t>,
        args: Args,
        (index, first): (Int, &'t NodeRow),
        cause: Cause,
    ) -> Result<Option<Reason>, Status> {
        if first.action() == LAUNCH && first.low() == NONE {
            self.launch(subject, args, cause)?;
            return Ok(None);
        }
        let mut waits = None;
        for number in 0..self.collect(index)? {
            let node = self.step(number)?;
            match node.action() {
                WAIT => {
                    waits = Some(reason(node.bound())?);
                    self.hold(subject, subject.place(), WAITING, args)?;
                }
                CLEAR | SETTLE => {
                    waits = Some(reason(node.bound())?);
                    self.hold(subject, subject.place(), CLEARING, args)?;
                }
                KILL => self.kill_target(node)?,
                DISMISS => {
                    let other = self.subject(node.high())?;
                    if self.is_waiting(other)? {
                        self.vacate(other, Why::Rule(reason(node.bound())?))?;
                    }
                }
                LAUNCH => self.launch(subject, args, cause)?,
                _ => return Err(Status::FaultDecision),
            }
        }
        Ok(waits)
    }

    /// Answer an ask, or the launch rule of this number, which requires one.
    #[inline]
    pub(crate) fn take_ask(&mut self, subject: Subject<'t>, rule: Option<Int>) -> Result<(), Status> {
        let args = Args::Given; // also without parameters: not those of what waits
        let taken = self.is_waiting(subject)?;
        if taken && subject.row.interrupts_self() == 0 {
            return self.refuse(subject, 0, rule); // busy
        }
        let decided = self.decide(subject, args)?;
        if decided.1.action() == REJECT {
            return self.refuse(subject, decided.1.bound(), rule);
        }
        if taken {
            let launch_rule = self.origin(subject)?;
            self.say(Action::Reject { request: Some(subject.id), why: Why::Superseded, launch_rule })?;
        }
        let mut number = NONE;
        if let Some(rule) = rule {
            number = self.tables.at(&self.tables.launches, rule)?.reason();
        }
        let launch_rule = if number == NONE { None } else { Some(reason(number)?) };
        let cause = Cause { required: launch_rule, launch_rule };
        if let Some(reason) = self.carry_out(subject, args, decided, cause)? {
            if LAUNCHES > 0 {
                at_mut(&mut self.origins, subject.index)?.set(number.wrapping_add(1) as Uint);
            }
            self.say(Action::Wait { request: subject.id, reason, launch_rule })?;
        }
        Ok(())
    }

    /// Reject a newcomer; without a word if the last step refused this launch rule for the same reason.
    fn refuse(&mut self, subject: Subject<'t>, number: Int, rule: Option<Int>) -> Result<(), Status> {
        let mut launch_rule = None;
        if let Some(rule) = rule {
            let refused = number.wrapping_add(1).wrapping_mul(2) as Uint;
            let cell = at_mut(&mut self.refused, rule)?;
            let before = cell.get()?;
            cell.set(refused.wrapping_add(1)); // odd until this step ends
            if before == refused {
                return Ok(());
            }
            launch_rule = Some(reason(self.tables.at(&self.tables.launches, rule)?.reason())?);
        }
        self.say(Action::Reject { request: Some(subject.id), why: Why::Rule(reason(number)?), launch_rule })
    }

    // ---- steps 3 to 5 ----

    fn recover(&mut self) -> Result<(), Status> {
        let (mut from, end) = (0, RULES as Int);
        self.agenda &= !DIRTY;
        while let Some(rule) = next_bit(&self.dirty, from, end)? {
            from = rule.wrapping_add(1);
            clear_bit(&mut self.dirty, rule)?;
            clear_bit(&mut self.broken, rule)?;
            for number in 0..self.collect(self.tables.at(&self.tables.rules, rule)?.root())? {
                let node = self.step(number)?;
                match node.action() {
                    KILL => self.kill_target(node)?,
                    VIOLATION => {
                        set_bit(&mut self.broken, rule)?;
                        self.agenda |= BROKEN;
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn launch_required(&mut self) -> Result<(), Status> {
        for number in 0..LAUNCHES as Int {
            let row = self.tables.at(&self.tables.launches, number)?;
            if has_bit(&self.marks, number)? || !self.agrees(row.condition())? {
                continue;
            }
            set_bit(&mut self.marks, number)?;
            self.agenda |= MARKED;
            let subject = self.subject(row.request())?;
            for k in 0..subject.row.arity() {
                let word = self.tables.at(&self.tables.lists, row.args().wrapping_add(k))?.word();
                let param = self.tables.at(&self.tables.params, subject.row.params().wrapping_add(k))?;
                let value = match param.kind() {
                    REAL => Value::from(self.tables.real(word)?),
                    _ => Value::from(i64::from(word)),
                };
                *at_mut(&mut self.given, k)? = value;
            }
            self.loaded = (Args::Nothing, false);
            self.take_ask(subject, Some(number))?;
        }
        Ok(())
    }

    /// Keep for what this step refused launch rules, and forget for what the last one did.
    fn forget_refusals(&mut self) -> Result<(), Status> {
        for cell in &mut self.refused {
            let refused = cell.get()?;
            cell.set(if refused & 1 != 0 { refused.wrapping_sub(1) } else { 0 });
        }
        Ok(())
    }

    fn settle(&mut self) -> Result<(), Status> {
        let (mut from, end) = (0, REQUESTS as Int);
        while let Some(request) = next_bit(&self.taken, from, end)? {
            from = request.wrapping_add(1);
            let subject = self.subject(request)?;
            let mark = (LAUNCHES as Int).wrapping_add(request);
            let args = self.args_of(subject.row, subject.place());
            let decided = self.decide(subject, args)?;
            match decided.1.action() {
                REJECT => self.vacate(subject, Why::Rule(reason(decided.1.bound())?))?,
                action if action == WAIT || !matches!(action, LAUNCH | DISMISS) && has_bit(&self.marks, mark)? => {
                    if self.phase(subject, subject.place())? == CLEARING {
                        set_bit(&mut self.marks, mark)?;
                        self.agenda |= MARKED;
                    }
                    self.hold(subject, subject.place(), WAITING, args)?;
                }
                _ => {
                    let cause = Cause { required: None, launch_rule: self.origin(subject)? };
                    self.carry_out(subject, args, decided, cause)?;
                }
            }
        }
        Ok(())
    }

    /// Raise every rule that is still broken once; the copies of a rule stand together.
    fn raise_violations(&mut self) -> Result<(), Status> {
        let (mut from, end, mut last) = (0, RULES as Int, NONE);
        self.agenda &= !BROKEN;
        while let Some(rule) = next_bit(&self.broken, from, end)? {
            from = rule.wrapping_add(1);
            let number = self.tables.at(&self.tables.rules, rule)?.reason();
            if number != last {
                self.say(Action::Violation { reason: reason(number)? })?;
            }
            last = number;
            self.agenda |= BROKEN;
        }
        Ok(())
    }

    /// End a step: repeat steps 3 to 5 until nothing changes, then tell what is still broken.
    pub(crate) fn attend(&mut self) -> Result<(), Status> {
        let mut passes = self.tables.at(&self.tables.limits, 0)?.passes();
        self.changed = true;
        while self.changed && self.agenda & !(BROKEN | MARKED) != 0 {
            self.changed = false;
            if passes <= 0 {
                return Err(Status::FaultPasses);
            }
            passes = passes.wrapping_sub(1);
            if self.agenda & DIRTY != 0 {
                self.recover()?;
            }
            self.launch_required()?;
            if self.agenda >= PLACE {
                self.settle()?;
            }
        }
        if self.agenda & BROKEN != 0 {
            self.raise_violations()?;
        }
        self.forget_refusals()?;
        if self.agenda & MARKED != 0 {
            self.agenda &= !MARKED;
            self.marks.fill(Cell::ZERO);
        }
        Ok(())
    }
}
