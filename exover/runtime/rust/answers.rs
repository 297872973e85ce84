//! What goes in and comes out: values, outcomes, actions, and what can be wrong.

use crate::names::{Reason, Request};

/// An argument, result or reading: the 64 bits of a real, or of an integer; a bool is 0 or 1, an enum value its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value(u64);

impl Value {
    pub(crate) const ZERO: Value = Value(0);

    /// The value with these bits.
    pub const fn from_bits(bits: u64) -> Value {
        Value(bits)
    }

    /// The bits of this value.
    pub const fn bits(self) -> u64 {
        self.0
    }

    /// What this is as a real.
    pub fn real(self) -> f64 {
        f64::from_bits(self.0)
    }

    /// What this is as an integer.
    pub const fn integer(self) -> i64 {
        self.0 as i64
    }

    pub(crate) const fn inverse(self) -> Value {
        Value(!self.0)
    }
}

impl From<f64> for Value {
    fn from(real: f64) -> Value {
        Value(real.to_bits())
    }
}

impl From<i64> for Value {
    fn from(integer: i64) -> Value {
        Value(integer as u64)
    }
}

impl From<bool> for Value {
    fn from(holds: bool) -> Value {
        Value(u64::from(holds))
    }
}

/// How a slot has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome<'a> {
    /// It succeeded, with these results.
    Ok(&'a [Value]),
    /// It failed, with the status of this index if it told one.
    Failed(Option<u32>),
    /// It was interrupted.
    Interrupted,
}

/// What the host shall do, or know. The codes, which are those of C, differ in seven bits of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Action {
    /// Start a slot; [`Checker::args`](crate::Checker::args) has its arguments.
    Launch {
        /// What starts.
        request: Request,
        /// The slot that starts.
        slot: u32,
        /// The launch rule that starts it at once, if one does.
        reason: Option<Reason>,
        /// The launch rule that it comes of, at once or after it has waited; none if it was asked for.
        launch_rule: Option<Reason>,
    } = 0x1e76,
    /// A request took its waiting place.
    Wait {
        /// What waits.
        request: Request,
        /// What it waits for.
        reason: Reason,
        /// The launch rule that it comes of; none if it was asked for.
        launch_rule: Option<Reason>,
    } = 0x4bdc,
    /// A request is refused.
    Reject {
        /// What is refused; none if it was a reading.
        request: Option<Request>,
        /// What for.
        why: Why,
        /// The launch rule that it comes of; none if it was asked for.
        launch_rule: Option<Reason>,
    } = 0x45aa,
    /// Stop a slot.
    Kill {
        /// What stops.
        request: Request,
        /// The slot that stops.
        slot: u32,
        /// What for.
        why: Why,
    } = 0x2f5b,
    /// A rule could not be restored.
    Violation {
        /// The rule.
        reason: Reason,
    } = 0x7455,
    /// The event was none; nothing was done.
    Invalid(Invalid) = 0x1369,
}

impl Action {
    /// The code of an answer, and its numbers as C tells them: request, slot, reason and launch rule.
    pub(crate) fn words(&self) -> (u32, [u32; 4]) {
        const NONE: u32 = u32::MAX;
        fn rule(reason: Option<Reason>) -> u32 {
            reason.map_or(NONE, |reason| reason.index() as u32)
        }
        match *self {
            Action::Launch { request, slot, reason, launch_rule } => {
                (0x1e76, [request.index() as u32, slot, rule(reason), rule(launch_rule)])
            }
            Action::Wait { request, reason, launch_rule } => {
                (0x4bdc, [request.index() as u32, NONE, rule(Some(reason)), rule(launch_rule)])
            }
            Action::Reject { request, why, launch_rule } => {
                let request = request.map_or(NONE, |request| request.index() as u32);
                (0x45aa, [request, NONE, why.number(), rule(launch_rule)])
            }
            Action::Kill { request, slot, why } => (0x2f5b, [request.index() as u32, slot, why.number(), NONE]),
            Action::Violation { reason } => (0x7455, [NONE, NONE, rule(Some(reason)), NONE]),
            Action::Invalid(what) => (0x1369, [NONE, NONE, what as u32, NONE]),
        }
    }

    /// The check word of an answer: it changes with any bit of the numbers that it holds.
    pub(crate) fn check(&self) -> u32 {
        let (code, words) = self.words();
        !words.iter().zip([3, 9, 5, 7]).fold(code, |sum, (word, times)| sum.wrapping_add(word.wrapping_mul(times)))
    }
}

/// What a slot (the first three) or a waiting place holds: a slot is active while it runs and while it stops, a place is
/// taken while it waits and while its way is cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Phase {
    Idle,
    Running,
    Stopping,
    Waiting,
    Clearing,
}

/// What stands in a slot or waiting place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// What it holds.
    pub phase: Phase,
    /// The number of the step that has put it there; 0 since loading.
    pub since: u32,
}

/// Why something is refused or stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// A rule of the spec.
    Rule(Reason),
    /// A newer ask of the same request took the waiting place.
    Superseded,
    /// The host's own abort.
    Aborted,
    /// The checker is faulty and denies everything.
    Faulty,
}

impl Why {
    pub(crate) fn number(self) -> u32 {
        match self {
            Why::Rule(reason) => reason.index() as u32,
            Why::Superseded => u32::MAX.wrapping_sub(1),
            Why::Aborted => u32::MAX.wrapping_sub(2),
            Why::Faulty => u32::MAX.wrapping_sub(3),
        }
    }
}

/// What is wrong with an event; the numbers are those of `enum exover_invalid`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Invalid {
    /// More values than parameters.
    UnknownArgument = 4,
    /// Fewer values than parameters.
    MissingArgument,
    /// A value out of its range, also NaN and infinities; of a poster with an `else` value: it was taken as that.
    OutOfRange,
    /// No such status.
    UnknownStatus,
    /// The slot is idle.
    NotActive,
    /// Nothing runs or waits there.
    NothingToAbort,
}

/// What was found when the tables were loaded, and what is wrong since; the numbers are those of `exover_status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Nothing is wrong.
    Ready = 0,
    /// The checker was never loaded.
    NotLoaded = 1,
    /// Not a table at all.
    NoMagic = 3,
    /// The format has another version.
    OtherFormat = 4,
    /// The tables have words of another width.
    OtherWidth = 5,
    /// The numbers of records are not those that were emitted.
    BadCounts = 7,
    /// A bit has changed.
    BadChecksum = 8,
    /// A path with more actions than the bound, or that turns back.
    FaultPath = 15,
    /// More answers than the bound.
    FaultActions = 16,
    /// More passes than the bound.
    FaultPasses = 17,
    /// A decision that decides nothing, or launches where no slot is idle.
    FaultDecision = 18,
    /// The two channels differ.
    FaultChannels = 19,
    /// A number that points outside of what it counts.
    FaultIndex = 20,
    /// What is remembered is not what its complement says.
    FaultState = 21,
    /// The checksum of the tables is not what it was.
    FaultTables = 22,
    /// The checker does not know any more where its tables are.
    FaultChecker = 23,
    /// What was answered has changed before it was returned.
    FaultAnswers = 25,
    /// It is loaded: the host has to say that everything was stopped.
    Live = 27,
    /// No record, of another version, cut short, or a bit has changed.
    BadRecord = 28,
    /// A record or a map of other tables.
    OtherTables = 29,
    /// A record that is not of the last step of this checker.
    Stale = 30,
    /// A number of a record that is out of range.
    BadValue = 31,
    /// What is active breaks a rule.
    BrokenRule = 32,
    /// No map, of another version, cut short, or a bit has changed.
    BadMap = 33,
    /// A request has to end before the tables are swapped.
    StillActive = 34,
}

impl Status {
    const ALL: [Status; 25] = [
        Status::Ready,
        Status::NotLoaded,
        Status::NoMagic,
        Status::OtherFormat,
        Status::OtherWidth,
        Status::BadCounts,
        Status::BadChecksum,
        Status::FaultPath,
        Status::FaultActions,
        Status::FaultPasses,
        Status::FaultDecision,
        Status::FaultChannels,
        Status::FaultIndex,
        Status::FaultState,
        Status::FaultTables,
        Status::FaultChecker,
        Status::FaultAnswers,
        Status::Live,
        Status::BadRecord,
        Status::OtherTables,
        Status::Stale,
        Status::BadValue,
        Status::BrokenRule,
        Status::BadMap,
        Status::StillActive,
    ];

    /// The status of this number; a number that is none has lost a bit.
    pub(crate) fn of(number: u32) -> Status {
        let known = Status::ALL.into_iter().find(|status| *status as u32 == number);
        known.unwrap_or(Status::FaultState)
    }
}

/// Why a step does not go on.
pub(crate) enum Stop {
    Event(Invalid),
    Fault(Status),
}

impl From<Invalid> for Stop {
    fn from(what: Invalid) -> Stop {
        Stop::Event(what)
    }
}

impl From<Status> for Stop {
    fn from(cause: Status) -> Stop {
        Stop::Fault(cause)
    }
}
