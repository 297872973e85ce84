//! Events: each call is one whole step, and returns the actions that answer it, in order.

use crate::answers::{Action, Invalid, Outcome, Phase, Status, Stop, Value, View, Why};
use crate::blackbox::What;
use crate::cells::Cell;
use crate::checker::{Checker, FAULTY};
use crate::names::{Poster, Request, Stock};
use crate::records::{at, at_mut, range, Domain, ParamRow, NONE, POSTER, REAL};
use crate::state::{Subject, CLEARING, EMPTY, RUNNING, SINCE, STOPPING, WAITING};
use crate::tables::{Int, Uint};

impl Checker<'_> {
    /// Somebody asks for a request with these arguments, in the order of its parameters.
    pub fn ask(&mut self, request: Request, args: &[Value]) -> &[Action] {
        self.note(What::Ask, [request.index() as u32, 0, 0, 0], args);
        let done = self.begin().and_then(|()| self.asked(request, args));
        self.end(done, Some(request));
        self.noted()
    }

    /// A slot has ended.
    pub fn report(&mut self, request: Request, slot: u32, outcome: Outcome<'_>) -> &[Action] {
        let (code, status, results) = match outcome {
            Outcome::Ok(results) => (1, None, results),
            Outcome::Failed(status) => (2, status, &[][..]),
            Outcome::Interrupted => (3, None, &[][..]),
        };
        self.note(What::Report, [request.index() as u32, slot, code, status.unwrap_or(u32::MAX)], results);
        let done = match self.begin() {
            Ok(()) => self.reported(request, slot, outcome),
            Err(fault) => self.forgotten(request, slot, outcome).and(Err(fault)),
        };
        self.end(done, Some(request));
        self.noted()
    }

    /// A poster reads a value.
    pub fn observe(&mut self, poster: Poster, value: Value) -> &[Action] {
        self.note(What::Observe, [poster.index() as u32, 0, 0, 0], &[value]);
        let done = self.begin().and_then(|()| self.observed(poster, value));
        self.end(done, None);
        self.noted()
    }

    /// A consumable resource has this level.
    pub fn observe_level(&mut self, stock: Stock, level: i64) -> &[Action] {
        self.note(What::Level, [stock.index() as u32, 0, 0, 0], &[level.into()]);
        let done = self.begin().and_then(|()| self.levelled(stock, level));
        self.end(done, None);
        self.noted()
    }

    /// A slot shall end. A faulty checker answers every abort by a kill, whatever it remembers.
    pub fn abort(&mut self, request: Request, slot: u32) -> &[Action] {
        self.note(What::Abort, [request.index() as u32, slot, 0, 0], &[]);
        if self.begin().is_ok() {
            let done = self.aborted(request, slot);
            self.end(done, Some(request));
        }
        if self.agenda & FAULTY != 0 {
            self.stop(request, slot);
            self.say_last(Action::Kill { request, slot, why: Why::Aborted });
            self.reject_waiting();
        }
        self.verified();
        self.noted()
    }

    /// What waits at a request is given up.
    pub fn abort_waiting(&mut self, request: Request) -> &[Action] {
        self.note(What::AbortWaiting, [request.index() as u32, 0, 0, 0], &[]);
        let done = self.begin().and_then(|()| self.given_up(request));
        self.end(done, Some(request));
        self.noted()
    }

    /// The arguments that a slot was launched with last, kept when it has ended; 0 before its first launch. None if there is no
    /// such slot, or if they are not what their complements say, which is a fault.
    pub fn args(&self, request: Request, slot: u32) -> Option<&[Value]> {
        if !self.knows_tables() {
            return None;
        }
        let row = self.slot(request, slot).ok()?.row;
        let first = row.values().wrapping_add((slot as Int).wrapping_mul(row.arity()));
        let behind = first.wrapping_add(row.arity());
        let (values, inverses) = (range(&self.values, first, behind).ok()?, range(&self.inverses, first, behind).ok()?);
        if values.iter().zip(inverses).all(|(value, inverse)| *value == inverse.inverse()) {
            return Some(values);
        }
        self.latch_fault(Status::FaultState);
        None
    }

    /// What a slot holds; None if there is no such slot, or if what is remembered has changed, which is a fault. Of a faulty
    /// checker it is what it remembers.
    pub fn view(&self, request: Request, slot: u32) -> Option<View> {
        if !self.knows_tables() {
            return None;
        }
        let subject = self.slot(request, slot).ok()?;
        self.view_at(subject, slot as Int)
    }

    /// What the waiting place of a request holds; None as for a slot.
    pub fn view_waiting(&self, request: Request) -> Option<View> {
        if !self.knows_tables() {
            return None;
        }
        let subject = self.slot(request, 0).ok()?;
        self.view_at(subject, subject.place())
    }

    /// The number of the last step: how many events were taken since loading, whatever they were; modulo 2^29 if the state
    /// has 32 bits, as is each `since`.
    pub fn steps(&self) -> u32 {
        ((self.steps as Uint).wrapping_mul(SINCE) / SINCE) as u32
    }

    fn view_at(&self, subject: Subject<'_>, slot: Int) -> Option<View> {
        let found = at(&self.phases, subject.phase_at(slot)).and_then(Cell::get);
        let held = found.map_err(|cause| self.latch_fault(cause)).ok()?;
        let phase = match held % SINCE {
            EMPTY => Phase::Idle,
            RUNNING => Phase::Running,
            STOPPING => Phase::Stopping,
            WAITING => Phase::Waiting,
            CLEARING => Phase::Clearing,
            _ => return None,
        };
        Some(View { phase, since: (held / SINCE) as u32 })
    }

    /// Whether the tables were emitted although the checks of their spec do not hold.
    pub fn unchecked(&self) -> bool {
        if !self.knows_tables() {
            return false;
        }
        let [_, _, flags, ..] = self.tables.head;
        flags & 1 != 0
    }
}

impl<'t> Checker<'t> {
    pub(crate) fn end(&mut self, done: Result<(), Stop>, request: Option<Request>) -> &[Action] {
        let ended = match done {
            Ok(()) if self.agenda == 0 => Ok(()),
            Ok(()) => self.attend().map_err(Stop::Fault),
            Err(stop) => Err(stop),
        };
        match ended {
            Ok(()) => self.close(),
            Err(Stop::Event(what)) => self.say_last(Action::Invalid(what)),
            Err(Stop::Fault(cause)) => {
                if self.agenda & FAULTY == 0 {
                    self.steps = self.steps.wrapping_sub(1); // what is remembered of it is not believed
                }
                self.fall(cause);
                self.deny(request);
            }
        }
        self.verified()
    }

    // ---- validation ----

    /// The request of a slot, if there is that slot.
    fn slot(&self, request: Request, slot: u32) -> Result<Subject<'t>, Stop> {
        let subject = self.subject(request.index() as Int)?;
        match Int::try_from(slot) {
            Ok(number) if number < subject.place() => Ok(subject),
            _ => Err(Invalid::OutOfRange.into()),
        }
    }

    pub(crate) fn in_domain(&self, domain: &Domain, value: Value) -> Result<bool, Status> {
        if domain.kind != REAL {
            return Ok((i64::from(domain.low)..=i64::from(domain.high)).contains(&value.integer()));
        }
        let low = self.tables.real(domain.low)?;
        let high = self.tables.real(domain.high)?;
        Ok(value.real().is_finite() && value.real() >= low && value.real() <= high)
    }

    /// Take values that are given for these parameters or results.
    fn take(&mut self, params: &[ParamRow], values: &[Value]) -> Result<(), Stop> {
        if values.len() > params.len() {
            return Err(Invalid::UnknownArgument.into());
        }
        if values.len() < params.len() {
            return Err(Invalid::MissingArgument.into());
        }
        for ((param, value), number) in params.iter().zip(values).zip(0..) {
            if !self.in_domain(&param.domain(), *value)? {
                return Err(Invalid::OutOfRange.into());
            }
            *at_mut(&mut self.given, number)? = *value;
        }
        Ok(())
    }

    /// Take what is reported of a slot that is active.
    fn take_report(&mut self, request: Request, slot: u32, outcome: Outcome<'_>) -> Result<Subject<'t>, Stop> {
        let subject = self.slot(request, slot)?;
        let row = subject.row;
        match outcome {
            Outcome::Ok(results) => {
                self.take(self.tables.range(&self.tables.params, row.results(), row.params_end())?, results)?;
            }
            Outcome::Failed(Some(status)) if i64::from(status) >= i64::from(row.statuses()) => {
                return Err(Invalid::UnknownStatus.into());
            }
            Outcome::Failed(_) | Outcome::Interrupted => {}
        }
        let cell = at(&self.phases, subject.phase_at(slot as Int))?;
        let held = if self.agenda & FAULTY == 0 { cell.get()? } else { cell.claimed() };
        if held % SINCE == EMPTY {
            return Err(Invalid::NotActive.into());
        }
        Ok(subject)
    }

    // ---- the steps ----

    #[inline]
    fn asked(&mut self, request: Request, args: &[Value]) -> Result<(), Stop> {
        let subject = self.slot(request, 0)?;
        self.take(self.tables.range(&self.tables.params, subject.row.params(), subject.row.results())?, args)?;
        Ok(self.take_ask(subject, None)?)
    }

    #[inline]
    fn reported(&mut self, request: Request, slot: u32, outcome: Outcome<'_>) -> Result<(), Stop> {
        let subject = self.take_report(request, slot, outcome)?;
        let (row, slot) = (subject.row, slot as Int);
        let phase = self.phase(subject, slot)?;
        let args = self.args_of(row, slot);
        self.occupy(subject.index, false)?;
        self.tally(row, slot, phase, false)?;
        self.set_phase(subject, slot, EMPTY)?;
        match outcome {
            Outcome::Ok(_) => {
                self.put(row.last(), 1)?;
                for past in self.tables.range(&self.tables.pasts, row.pasts(), row.pasts_end())? {
                    let fits = self.fits(row, past.predicate(), args, true)?;
                    self.put(past.entry(), Int::from(fits))?;
                }
                self.produce(row, args)?;
                self.affect(row.on_ok(), row.on_failed())?;
                return Ok(self.latch(subject.index)?);
            }
            Outcome::Failed(_) => {
                self.put(row.last(), 2)?;
                self.affect(row.on_failed(), row.on_interrupted())?;
            }
            Outcome::Interrupted => {
                self.put(row.last(), 3)?;
                self.affect(row.on_interrupted(), row.effects_end())?;
            }
        }
        Ok(self.latch(NONE)?)
    }

    /// What a faulty checker does with a report: the rest of the state is not trusted any more.
    fn forgotten(&mut self, request: Request, slot: u32, outcome: Outcome<'_>) -> Result<(), Stop> {
        if self.knows_tables() {
            let subject = self.take_report(request, slot, outcome)?;
            self.set_phase(subject, slot as Int, EMPTY)?;
        }
        Ok(())
    }

    fn observed(&mut self, poster: Poster, value: Value) -> Result<(), Stop> {
        let row = self.tables.at(&self.tables.variables, poster.index() as Int)?;
        if row.role() != POSTER {
            return Err(Status::FaultIndex.into());
        }
        let mut taken = value;
        if !self.in_domain(&row.domain(), value)? {
            if row.has_fallback() == 0 {
                return Err(Invalid::OutOfRange.into());
            }
            self.say_last(Action::Invalid(Invalid::OutOfRange));
            let fallback = match row.kind() {
                REAL => Value::from(self.tables.real(row.fallback())?),
                _ => Value::from(i64::from(row.fallback())),
            };
            taken = fallback;
        }
        self.read(row, taken)?;
        Ok(self.latch(NONE)?)
    }

    fn levelled(&mut self, stock: Stock, level: i64) -> Result<(), Stop> {
        let row = self.tables.at(&self.tables.stocks, stock.index() as Int)?;
        if !(0..=i64::from(row.capacity())).contains(&level) {
            return Err(Invalid::OutOfRange.into());
        }
        self.put(row.entry(), level as Int)?;
        Ok(self.latch(NONE)?)
    }

    fn aborted(&mut self, request: Request, slot: u32) -> Result<(), Stop> {
        let subject = self.slot(request, slot)?;
        if self.phase(subject, slot as Int)? == EMPTY {
            return Err(Invalid::NothingToAbort.into());
        }
        Ok(self.kill(subject, slot as Int, Why::Aborted)?)
    }

    /// What a faulty checker does with an abort, so that the end of the slot can be reported.
    fn stop(&mut self, request: Request, slot: u32) {
        if !self.knows_tables() {
            return;
        }
        if let Ok(subject) = self.slot(request, slot) {
            if let Ok(cell) = at_mut(&mut self.phases, subject.phase_at(slot as Int)) {
                cell.set(STOPPING);
            }
        }
    }

    fn given_up(&mut self, request: Request) -> Result<(), Stop> {
        let subject = self.slot(request, 0)?;
        if self.phase(subject, subject.place())? == EMPTY {
            return Err(Invalid::NothingToAbort.into());
        }
        Ok(self.vacate(subject, Why::Aborted)?)
    }
}
