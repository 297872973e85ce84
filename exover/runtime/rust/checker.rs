//! The checker: all that it holds, how a step begins and ends, what it says; loading, scrubbing, faults.

use crate::answers::{Action, Invalid, Status, Stop, Value, Why};
use crate::cells::{may_have_bit, set_bit, Args, Cell};
use crate::names::Request;
use crate::records::{raw, Place, Tables};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use crate::tables::{self, Int, Uint, Word, CAPACITY, ENTRIES, LAUNCHES, PATH, REQUESTS, RULES, SLOTS, VALUES};

/// How many bytes of the tables every step looks at again, besides one cell or value.
const SCRUB: u32 = 4;

// The agenda, what the end of a step has to look at: rules, broken rules, marks of this step, launch rules, a fault, of
// which all that waits was told; and how many waiting places are taken, times `PLACE`.
pub const DIRTY: u32 = 1;
pub const BROKEN: u32 = 2;
pub const MARKED: u32 = 4;
pub const REQUIRED: u32 = 8;
pub const FAULTY: u32 = 16;
pub const TOLD: u32 = 32;
pub const PLACE: u32 = 64;

/// Of a checker that was loaded.
const LIVE: u32 = 0x11fe_11fe;

const fn cells(count: usize, bits: usize) -> usize {
    count.div_ceil(bits)
}

/// A checker, which belongs to whoever calls it: the tables are shared, nothing else is.
///
/// But for the tables it holds numbers only; [`Checker::load`] makes them those of the initial state.
pub struct Checker<'t> {
    pub(crate) tables: &'t Tables,
    /// The complement of the address of the tables.
    seal: usize,
    /// Atomic, since reading arguments can find one; nothing else is shared.
    fault: AtomicU32,
    pub(crate) agenda: u32,
    /// The complement of the agenda, but of a faulty checker; no single bit makes a faulty one sound.
    guard: u32,
    scrubbed: Place,
    compared: usize,
    pub(crate) steps: u32,
    #[cfg(feature = "black-box")]
    pub(crate) log: crate::blackbox::BlackBox<'t>,
    /// `LIVE` since it was loaded.
    live: u32,

    /// The entries that the diagrams test.
    pub(crate) vector: [Cell; ENTRIES],
    /// Of every request: its slots, then its waiting place.
    pub(crate) phases: [Cell; SLOTS + REQUESTS],
    /// Of every request, how many slots are active: for the bit rows alone, as the next.
    pub(crate) held: [Cell; REQUESTS],
    /// Bits: requests of which a slot is active, 16 to a cell.
    pub(crate) active: [Cell; cells(REQUESTS, 16)],
    /// Bits, 32 to a cell: rules to look at.
    pub(crate) dirty: [Cell; cells(RULES, 32)],
    /// Rules that could not be restored.
    pub(crate) broken: [Cell; cells(RULES, 32)],
    /// Requests whose waiting place is taken.
    pub(crate) taken: [Cell; cells(REQUESTS, 32)],
    /// If there are launch rules, of every request: the reason of the rule that put there what waits, and one.
    pub(crate) origins: [Cell; if LAUNCHES > 0 { REQUESTS } else { 0 }],
    /// Of every launch rule, for what the last step refused it: twice (a reason, and one), or 0 if it did not.
    pub(crate) refused: [Cell; LAUNCHES],
    /// For one step: launch rules that were tried, requests that fell to waiting.
    pub(crate) marks: [Cell; cells(LAUNCHES + REQUESTS, 32)],
    /// Arguments of slots and waiting places, then real posters that are compared with other reals.
    pub(crate) values: [Value; VALUES],
    pub(crate) inverses: [Value; VALUES],

    // For one step.
    pub(crate) given: [Value; tables::GIVEN],
    /// Which arguments the entries of arguments have now, and whether with results.
    pub(crate) loaded: (Args, bool),
    pub(crate) changed: bool,
    pub(crate) path: [Word; PATH],
    actions: [Action; CAPACITY + 1], // one more for a fault
    /// The check words of the answers.
    checks: [u32; CAPACITY + 1],
    count: usize,
}

impl<'t> Checker<'t> {
    /// The bytes that a checker takes; it has no others.
    pub const BYTES: usize = core::mem::size_of::<Self>();

    /// A checker that is not loaded yet, and denies everything.
    pub const fn new(tables: &'t Tables) -> Checker<'t> {
        Checker {
            tables,
            seal: 0,
            fault: AtomicU32::new(Status::NotLoaded as u32),
            agenda: FAULTY,
            guard: FAULTY,
            scrubbed: Place::START,
            compared: 0,
            steps: 0,
            #[cfg(feature = "black-box")]
            log: crate::blackbox::BlackBox::CLOSED,
            live: 0,
            vector: [Cell::ZERO; ENTRIES],
            phases: [Cell::ZERO; SLOTS + REQUESTS],
            held: [Cell::ZERO; REQUESTS],
            active: [Cell::ZERO; cells(REQUESTS, 16)],
            dirty: [Cell::ZERO; cells(RULES, 32)],
            broken: [Cell::ZERO; cells(RULES, 32)],
            taken: [Cell::ZERO; cells(REQUESTS, 32)],
            origins: [Cell::ZERO; if LAUNCHES > 0 { REQUESTS } else { 0 }],
            refused: [Cell::ZERO; LAUNCHES],
            marks: [Cell::ZERO; cells(LAUNCHES + REQUESTS, 32)],
            values: [Value::ZERO; VALUES],
            inverses: [Value::ZERO.inverse(); VALUES],
            given: [Value::ZERO; tables::GIVEN],
            loaded: (Args::Nothing, false),
            changed: false,
            path: [0; PATH],
            actions: [Action::Invalid(Invalid::OutOfRange); CAPACITY + 1],
            checks: [0; CAPACITY + 1],
            count: 0,
        }
    }

    /// Look at all bytes of the tables, and begin in the initial state; [`Status::Ready`], or why everything is denied. But
    /// [`Status::Live`] if it is loaded already, faulty or not: what runs would be forgotten, so it stays as it is.
    pub fn load(&mut self) -> Status {
        if self.is_live() {
            return Status::Live;
        }
        self.begin_anew()
    }

    /// The same, also if it is loaded already: the host says that everything it has launched was stopped.
    pub fn load_stopped(&mut self) -> Status {
        self.begin_anew()
    }

    /// Whether it was loaded, and so may have launched what still runs: no one bit decides it.
    pub(crate) fn is_live(&self) -> bool {
        self.live == LIVE || self.knows_tables()
    }

    pub(crate) fn set_live(&mut self, live: bool) {
        self.live = if live { LIVE } else { 0 };
    }

    pub(crate) fn begin_anew(&mut self) -> Status {
        let regions = [
            self.vector.as_mut_slice(),
            self.phases.as_mut_slice(),
            self.held.as_mut_slice(),
            self.active.as_mut_slice(),
            self.dirty.as_mut_slice(),
            self.broken.as_mut_slice(),
            self.taken.as_mut_slice(),
            self.origins.as_mut_slice(),
            self.refused.as_mut_slice(),
            self.marks.as_mut_slice(),
        ];
        for region in regions {
            region.fill(Cell::ZERO);
        }
        self.values.fill(Value::ZERO);
        self.inverses.fill(Value::ZERO.inverse());
        self.scrubbed = Place::START;
        self.compared = 0;
        self.steps = 0;
        self.count = 0;
        self.seal = !self.address();
        self.live = LIVE;
        self.fault.store(Status::Ready as u32, Relaxed);
        match self.tables.check().and_then(|()| self.start()) {
            Ok(()) => self.guard = !self.agenda,
            Err(cause) => {
                self.fall(cause);
                self.forget_tables();
                self.set_live(false);
            }
        }
        self.reopened();
        self.fault()
    }

    /// Posters and states as they start, every rule to be looked at, everything else idle.
    fn start(&mut self) -> Result<(), Status> {
        for (cell, row) in self.vector.iter_mut().zip(&self.tables.entries) {
            cell.set(row.initial() as Uint);
        }
        for row in &self.tables.variables {
            if row.raw() >= 0 {
                let initial = self.tables.real(row.initial())?;
                self.keep(raw(row), Value::from(initial))?;
            }
        }
        for rule in 0..RULES {
            set_bit(&mut self.dirty, rule as Int)?;
        }
        self.agenda = if RULES > 0 { DIRTY } else { 0 } | if LAUNCHES > 0 { REQUIRED } else { 0 };
        Ok(())
    }

    // ---- faults, and the checker itself ----

    /// [`Status::Ready`], or why everything is denied.
    pub fn fault(&self) -> Status {
        Status::of(self.fault.load(Relaxed))
    }

    /// Remember a fault, from which the next step falls.
    pub(crate) fn latch_fault(&self, cause: Status) {
        if self.fault.load(Relaxed) == Status::Ready as u32 {
            self.fault.store(cause as u32, Relaxed);
        }
    }

    pub(crate) fn fall(&mut self, cause: Status) {
        self.latch_fault(cause);
        if self.agenda & FAULTY == 0 {
            self.agenda = self.agenda & !TOLD | FAULTY;
        }
        self.guard = self.agenda;
    }

    fn address(&self) -> usize {
        self.tables as *const Tables as usize
    }

    /// Whether the checker knows where its tables are.
    pub(crate) fn knows_tables(&self) -> bool {
        self.seal == !self.address()
    }

    /// Begin an event, or tell why everything is denied.
    #[inline]
    pub(crate) fn begin(&mut self) -> Result<(), Stop> {
        self.count = 0;
        self.loaded = (Args::Nothing, false);
        self.look().map_err(|cause| {
            self.fall(cause);
            Stop::from(cause)
        })?;
        self.steps = self.steps.wrapping_add(1);
        Ok(())
    }

    /// Whether anything is wrong with the checker.
    #[inline]
    pub(crate) fn look(&mut self) -> Result<(), Status> {
        if self.fault.load(Relaxed) != Status::Ready as u32 {
            return Err(self.fault());
        }
        if !self.knows_tables() {
            self.forget_tables();
            return Err(Status::FaultChecker);
        }
        if self.guard != !self.agenda || self.agenda & FAULTY != 0 {
            return Err(Status::FaultState);
        }
        self.look_again(SCRUB)
    }

    /// In idle time: look at the next bytes of the tables, and at one cell or value for each four of them; [`Status::Ready`],
    /// or why everything is denied from the next event on. Bound: one look at each of these bytes.
    pub fn scrub(&mut self, bytes: u32) -> Status {
        if self.fault() == Status::Ready {
            if let Err(cause) = self.look().and_then(|()| self.idle(bytes)) {
                self.fall(cause);
            }
        }
        self.fault()
    }

    fn idle(&mut self, bytes: u32) -> Result<(), Status> {
        let mut left = bytes;
        while left > 0 {
            self.look_again(SCRUB)?;
            left = left.saturating_sub(SCRUB);
        }
        Ok(())
    }

    /// For good: no address is its own complement.
    pub(crate) fn forget_tables(&mut self) {
        self.seal = self.address();
    }

    /// The end of a step of which nothing is left to do.
    #[inline]
    pub(crate) fn close(&mut self) {
        self.guard = !self.agenda;
    }

    /// Look at the next bytes of the tables, and at the next of what is remembered.
    fn look_again(&mut self, bytes: u32) -> Result<(), Status> {
        let mut room = bytes;
        while room > 0 {
            let (bytes, ended) = self.tables.add_number(&mut self.scrubbed);
            room = room.saturating_sub(bytes);
            if ended {
                let right = self.tables.is_sum(self.scrubbed);
                self.scrubbed = Place::START;
                if !right {
                    return Err(Status::FaultTables);
                }
            }
        }
        let next = self.compared;
        self.compared = next.wrapping_add(1);
        match self.remembered(next) {
            Some(true) => Ok(()),
            Some(false) => Err(Status::FaultState),
            None => {
                self.compared = 0;
                Ok(())
            }
        }
    }

    /// Whether a cell or value is what its complement says; None behind the last.
    fn remembered(&self, mut index: usize) -> Option<bool> {
        let regions = [
            self.vector.as_slice(),
            self.phases.as_slice(),
            self.held.as_slice(),
            self.active.as_slice(),
            self.dirty.as_slice(),
            self.broken.as_slice(),
            self.taken.as_slice(),
            self.origins.as_slice(),
            self.refused.as_slice(),
            self.marks.as_slice(),
        ];
        for region in regions {
            match index.checked_sub(region.len()) {
                None => return region.get(index).map(Cell::is_sound),
                Some(left) => index = left,
            }
        }
        self.values.get(index).zip(self.inverses.get(index)).map(|(now, inverse)| *now == inverse.inverse())
    }

    // ---- answers ----

    /// The answers to an event, if all of them are what was said; else the kills among them, and rejections.
    #[inline]
    pub(crate) fn verified(&mut self) -> &[Action] {
        if self.count > self.actions.len() || !self.actions().iter().zip(&self.checks).all(|(said, check)| said.check() == *check) {
            self.fall(Status::FaultAnswers);
            self.count = self.count.min(self.actions.len());
            self.deny(None);
        }
        self.actions()
    }

    /// The answers to the last event, in order.
    pub fn actions(&self) -> &[Action] {
        self.actions.get(..self.count).unwrap_or(&[])
    }

    #[inline]
    pub(crate) fn say(&mut self, action: Action) -> Result<(), Status> {
        if self.count >= CAPACITY {
            return Err(Status::FaultActions);
        }
        self.say_last(action);
        Ok(())
    }

    /// Say something that the last place is kept for.
    #[inline]
    pub(crate) fn say_last(&mut self, action: Action) {
        if let Some((place, check)) = self.actions.get_mut(self.count).zip(self.checks.get_mut(self.count)) {
            *check = action.check();
            *place = action;
            self.count = self.count.wrapping_add(1);
        }
    }

    /// Nothing starts in a step that ends with a fault, but what was told to stop shall stop. Whatever else would have
    /// started or was given up is rejected, and what waits; at last what was asked for.
    pub(crate) fn deny(&mut self, request: Option<Request>) {
        let said = core::mem::take(&mut self.count);
        for index in 0..said {
            let holds = |(said, check): &(&Action, &u32)| said.check() == **check;
            let said = self.actions.get(index).zip(self.checks.get(index)).filter(holds).map(|(said, _)| *said);
            match said {
                Some(kill @ Action::Kill { .. }) => self.say_last(kill),
                Some(Action::Launch { request: other, .. } | Action::Reject { request: Some(other), .. })
                    if Some(other) != request =>
                {
                    self.refuse_faulty(Some(other));
                }
                _ => {}
            }
        }
        self.reject_waiting();
        self.refuse_faulty(request);
    }

    fn refuse_faulty(&mut self, request: Option<Request>) {
        self.say_last(Action::Reject { request, why: Why::Faulty, launch_rule: None });
    }

    /// Reject what waits, once: a faulty checker launches nothing.
    pub(crate) fn reject_waiting(&mut self) {
        if self.agenda & TOLD != 0 {
            return;
        }
        self.agenda |= TOLD;
        self.guard = self.agenda;
        for request in Request::ALL {
            if may_have_bit(&self.taken, request.index() as Int) {
                self.refuse_faulty(Some(request));
            }
        }
    }
}
