//! The state of a checker goes out in a record, and comes back after it was held against the tables; docs/runtime.md has the
//! layouts.

use crate::answers::{Action, Status, Stop, Value};
use crate::cells::{set_bit, Args, Cell};
use crate::checker::{Checker, PLACE};
use crate::records::{at, at_mut, crc, raw, Tables, VariableRow, KILL, NONE, REAL};
use crate::state::{Subject, CLEARING, EMPTY, SINCE, STOPPING, WAITING};
use crate::tables::{Int, Uint, INVARIANTS, LAUNCHES, REASONS, REQUESTS, RULES, STOCKS, VARIABLES};

const RECORD: u32 = 0x524f_5845; // "EXOR"
const MAP: u32 = 0x4d4f_5845; // "EXOM"
const VERSION: u64 = 1;
const HEAD: usize = 56;
const MAP_HEAD: usize = 100;
/// The sha256 of a spec and the checksum of its tables.
const NAMES: usize = 36;
const NOTHING: u64 = 0xffff_ffff;
/// The bits of a phase, below the step since when.
const PHASE: u64 = (SINCE as u64).wrapping_sub(1);
/// A phase since the greatest step of any build; here the steps count modulo fewer if the state has 32 bits.
const MOST_SINCE: u64 = (SINCE as u64).wrapping_mul(u32::MAX as u64) | PHASE;

/// Numbers on their way: into a record, out of one, or out of that of other tables by a map.
enum Way<'b> {
    Out(&'b mut [u8]),
    In(&'b [u8]),
    By { record: &'b [u8], map: &'b [u8] },
}

struct Transfer<'b> {
    way: Way<'b>,
    at: usize,
}

/// A number of so many bytes, little-endian; none behind the end.
fn get(bytes: &[u8], at: usize, size: usize) -> Option<u64> {
    let found = bytes.get(at..at.checked_add(size)?)?;
    Some(found.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
}

fn put(bytes: &mut [u8], at: usize, size: usize, number: u64) -> Option<()> {
    let place = bytes.get_mut(at..at.checked_add(size)?)?;
    for (byte, from) in place.iter_mut().zip(number.to_le_bytes()) {
        *byte = from;
    }
    Some(())
}

/// Where the `number`-th of things of so many bytes stands.
fn place(first: usize, size: usize, number: usize) -> usize {
    first.saturating_add(size.saturating_mul(number))
}

/// The checksum of a record or map, its own four bytes taken as 0.
fn sum_of(bytes: &[u8]) -> u64 {
    let mut sum = u32::MAX;
    for (number, byte) in bytes.iter().enumerate() {
        sum = crc(sum, if (8..12).contains(&number) { 0 } else { u64::from(*byte) }, 1);
    }
    u64::from(!sum)
}

fn is_whole(bytes: &[u8], magic: u32, least: usize) -> bool {
    bytes.len() >= least
        && get(bytes, 0, 4) == Some(u64::from(magic))
        && get(bytes, 4, 4) == Some(VERSION)
        && get(bytes, 12, 4) == Some(bytes.len() as u64)
        && get(bytes, 8, 4) == Some(sum_of(bytes))
}

impl Tables {
    /// What names these tables, byte by byte: the sha256 of their spec, then their checksum.
    fn names(&self) -> impl Iterator<Item = u8> + '_ {
        let (digest, checksum) = (self.head.iter().skip(5).take(8), self.head.iter().skip(3).take(1));
        digest.chain(checksum).flat_map(|word| word.to_le_bytes())
    }

    fn are_named(&self, bytes: &[u8], at: usize) -> bool {
        let named = bytes.iter().skip(at).take(NAMES);
        named.len() == NAMES && named.copied().eq(self.names())
    }
}

impl Transfer<'_> {
    fn reads(&self) -> bool {
        !matches!(self.way, Way::Out(_))
    }

    /// Let the next number pass; what stands there now if it stays.
    fn pass(&mut self, now: u64) -> Result<u64, Status> {
        let at = self.at;
        self.at = at.wrapping_add(1);
        match &mut self.way {
            Way::Out(bytes) => put(bytes, place(HEAD, 8, at), 8, now).map(|()| now).ok_or(Status::BadRecord),
            Way::In(bytes) => get(bytes, place(HEAD, 8, at), 8).ok_or(Status::BadRecord),
            Way::By { record, map } => mapped(record, map, at, now),
        }
    }
}

/// What a map makes of the numbers of the other tables; what stands there if it says nothing of it.
fn mapped(record: &[u8], map: &[u8], at: usize, now: u64) -> Result<u64, Status> {
    let head = |number| get(map, place(88, 4, number), 4).map(|found| found as usize);
    let (idle, numbers) = (head(0).ok_or(Status::BadMap)?, head(1).ok_or(Status::BadMap)?);
    let (pairs, lists) = (place(MAP_HEAD, 4, idle), place(place(MAP_HEAD, 4, idle), 8, numbers));
    let source = get(map, place(pairs, 8, at), 4).filter(|_| at < numbers).ok_or(Status::BadMap)?;
    let list = get(map, place(pairs, 8, at).saturating_add(4), 4).ok_or(Status::BadMap)?;
    if source == NOTHING {
        return Ok(now);
    }
    let number = get(record, place(HEAD, 8, source as usize), 8).ok_or(Status::BadMap)?;
    if list == NOTHING {
        return Ok(number);
    }
    let length = get(map, place(lists, 4, list as usize), 4).ok_or(Status::BadMap)?;
    if number >= length {
        return Err(Status::BadValue);
    }
    get(map, place(lists, 4, place(list as usize, 1, number as usize).saturating_add(1)), 4).ok_or(Status::BadMap)
}

/// Whether a map leads from the tables of a record to these, and what has to be idle is.
fn may_swap<'b>(tables: &Tables, record: &'b [u8], map: &'b [u8]) -> Result<(), Status> {
    if !is_whole(map, MAP, MAP_HEAD) {
        return Err(Status::BadMap);
    }
    let head = |number| get(map, place(88, 4, number), 4).map_or(0, |found| found as usize);
    let (idle, numbers, lists) = (head(0), head(1), head(2));
    if place(place(place(MAP_HEAD, 4, idle), 8, numbers), 4, lists) != map.len() {
        return Err(Status::BadMap);
    }
    let names = |bytes: &'b [u8]| bytes.iter().skip(16).take(NAMES);
    if !names(map).eq(names(record)) || !tables.are_named(map, 52) {
        return Err(Status::OtherTables);
    }
    for number in 0..idle {
        let at = get(map, place(MAP_HEAD, 4, number), 4).ok_or(Status::BadMap)?;
        let held = get(record, place(HEAD, 8, at as usize), 8).ok_or(Status::BadMap)?;
        if held & PHASE != EMPTY as u64 {
            return Err(Status::StillActive);
        }
    }
    Ok(())
}

impl<'t> Checker<'t> {
    /// Write what is remembered into a record, `RECORD_BYTES` of them; how many bytes it has, none if there is no room, or if
    /// the checker is faulty or finds that it is. Bound: one look at all that is remembered.
    pub fn export(&mut self, record: &mut [u8]) -> Option<usize> {
        let mut transfer = Transfer { way: Way::Out(record), at: 0 };
        match self.look().and_then(|()| self.pass_all(&mut transfer)) {
            Ok(()) => {}
            Err(Status::BadRecord) => return None,
            Err(cause) => {
                self.fall(cause);
                return None;
            }
        }
        let length = place(HEAD, 8, transfer.at);
        let bytes = record.get_mut(..length)?;
        let names = RECORD.to_le_bytes().into_iter().chain(VERSION.to_le_bytes().into_iter().take(4)).chain([0; 4]);
        let head = names.chain((length as u32).to_le_bytes()).chain(self.tables.names()).chain(self.steps.to_le_bytes());
        for (byte, from) in bytes.iter_mut().zip(head) {
            *byte = from;
        }
        let sum = sum_of(bytes);
        put(bytes, 8, 4, sum)?;
        Some(length)
    }

    /// As [`Checker::load`], but in the state of a record, which is held against the tables first: every number in its range,
    /// no rule broken. A checker that is loaded already is resumed only if it is faulty and the record is of the last step
    /// before. Bound: one look at every byte of the tables and of the record, and at every rule.
    pub fn resume(&mut self, record: &[u8]) -> Status {
        if self.is_live() && self.fault() == Status::Ready {
            return Status::Live;
        }
        if !is_whole(record, RECORD, HEAD) {
            return Status::BadRecord;
        }
        if !self.tables.are_named(record, 16) {
            return Status::OtherTables;
        }
        if self.is_live() && get(record, 52, 4) != Some(u64::from(self.steps)) {
            return Status::Stale;
        }
        self.admit(record, Way::In(record))
    }

    /// Go on from the record of a checker of other tables, by a map that `exover swap` has made; what waits is decided anew,
    /// which is what is answered. Of a checker that is not loaded yet. Bound: that of `resume`, and `PASSES` passes.
    pub fn swap(&mut self, record: &[u8], map: &[u8]) -> Result<&[Action], Status> {
        if self.is_live() {
            return Err(Status::Live);
        }
        if !is_whole(record, RECORD, HEAD) {
            return Err(Status::BadRecord);
        }
        may_swap(self.tables, record, map)?;
        match self.admit(record, Way::By { record, map }) {
            Status::Ready => {
                let done = self.begin().and_then(|()| self.latch(NONE).map_err(Stop::Fault));
                Ok(self.end(done, None))
            }
            cause => Err(cause),
        }
    }

    /// Begin in the state that passes, if it may be.
    fn admit(&mut self, record: &[u8], way: Way<'_>) -> Status {
        let live = self.is_live();
        let steps = get(record, 52, 4).map_or(0, |steps| steps as u32);
        let by_map = matches!(way, Way::By { .. });
        let mut transfer = Transfer { way, at: 0 };
        let passed = match self.begin_anew() {
            Status::Ready => self.pass_all(&mut transfer),
            cause => Err(cause),
        };
        self.steps = steps;
        let all = by_map || place(HEAD, 8, transfer.at) == record.len();
        match passed.and(if all { Ok(()) } else { Err(Status::BadRecord) }).and_then(|()| self.keeps_rules()) {
            Ok(()) => self.close(),
            Err(cause) => {
                self.fall(cause);
                self.forget_tables();
                self.set_live(live);
            }
        }
        self.fault()
    }

    // ---- what passes ----

    /// All that is remembered: readings and levels first, since what slots count for may depend on them.
    fn pass_all(&mut self, transfer: &mut Transfer<'_>) -> Result<(), Status> {
        let tables = self.tables;
        for row in tables.range(&tables.variables, 0, VARIABLES as Int)? {
            self.pass_variable(transfer, row)?;
        }
        for row in tables.range(&tables.stocks, 0, STOCKS as Int)? {
            self.pass_entry(transfer, row.entry(), 0, row.capacity())?;
        }
        for request in 0..REQUESTS as Int {
            self.pass_request(transfer, self.subject(request)?)?;
        }
        for rule in 0..LAUNCHES as Int {
            let now = at(&self.refused, rule)?.get()?;
            let refused = transfer.pass(now as u64)?;
            if refused % 2 != 0 || refused > (REASONS as u64).wrapping_mul(2) {
                return Err(Status::BadValue);
            }
            at_mut(&mut self.refused, rule)?.set(refused as Uint);
        }
        Ok(())
    }

    /// The number of an entry, which lies within these bounds; 0 if nothing reads it.
    fn pass_entry(&mut self, transfer: &mut Transfer<'_>, entry: Int, low: Int, high: Int) -> Result<(), Status> {
        let now = if entry < 0 { 0 } else { at(&self.vector, entry)?.get()? as Int };
        let number = transfer.pass(i64::from(now) as u64)? as i64;
        if entry < 0 || !transfer.reads() {
            return Ok(());
        }
        if !(i64::from(low)..=i64::from(high)).contains(&number) {
            return Err(Status::BadValue);
        }
        self.put(entry, number as Int)
    }

    fn pass_variable(&mut self, transfer: &mut Transfer<'_>, row: &'t VariableRow) -> Result<(), Status> {
        if row.raw() >= 0 {
            let now = self.kept(raw(row))?;
            let value = Value::from_bits(transfer.pass(now.bits())?);
            if !self.in_domain(&row.domain(), value)? {
                return Err(Status::BadValue);
            }
            return if transfer.reads() { self.read(row, value) } else { Ok(()) };
        }
        if row.kind() == REAL {
            let cuts = row.cuts_end().wrapping_sub(row.cuts());
            return self.pass_entry(transfer, row.rank(), 0, cuts.wrapping_mul(2));
        }
        self.pass_entry(transfer, row.value(), row.low(), row.high())
    }

    fn pass_request(&mut self, transfer: &mut Transfer<'_>, subject: Subject<'t>) -> Result<(), Status> {
        let row = subject.row;
        self.pass_entry(transfer, row.last(), 0, 3)?;
        for past in self.tables.range(&self.tables.pasts, row.pasts(), row.pasts_end())? {
            self.pass_entry(transfer, past.entry(), 0, 1)?;
        }
        for slot in 0..=subject.place() {
            self.pass_slot(transfer, subject, slot)?;
        }
        Ok(())
    }

    /// What a slot or waiting place holds.
    fn pass_slot(&mut self, transfer: &mut Transfer<'_>, subject: Subject<'t>, slot: Int) -> Result<(), Status> {
        let is_place = slot == subject.place();
        let now = at(&self.phases, subject.phase_at(slot))?.get()?;
        let number = transfer.pass(now as u64)?;
        let phase = (number & PHASE) as Uint;
        let fits_in = if is_place { [EMPTY, WAITING, CLEARING].contains(&phase) } else { phase <= STOPPING };
        if !fits_in || number > MOST_SINCE {
            return Err(Status::BadValue);
        }
        self.pass_args(transfer, subject, slot, phase != EMPTY)?;
        if is_place && LAUNCHES > 0 {
            let now = at(&self.origins, subject.index)?.get()?;
            let reason = transfer.pass(now as u64)?;
            if reason > REASONS as u64 {
                return Err(Status::BadValue);
            }
            at_mut(&mut self.origins, subject.index)?.set(reason as Uint);
        }
        if !transfer.reads() {
            return Ok(());
        }
        at_mut(&mut self.phases, subject.phase_at(slot))?.set(number as Uint);
        if phase == EMPTY {
            return Ok(());
        }
        if is_place {
            self.agenda = self.agenda.wrapping_add(PLACE);
            set_bit(&mut self.taken, subject.index)?;
        } else {
            self.occupy(subject.index, true)?;
        }
        self.tally(subject.row, slot, phase, true)
    }

    fn pass_args(
        &mut self,
        transfer: &mut Transfer<'_>,
        subject: Subject<'t>,
        slot: Int,
        held: bool,
    ) -> Result<(), Status> {
        let Args::Kept(first) = self.args_of(subject.row, slot) else {
            return Ok(());
        };
        self.loaded = (Args::Nothing, false);
        for k in 0..subject.row.arity() {
            let number = first.wrapping_add(k);
            let value = Value::from_bits(transfer.pass(self.kept(number)?.bits())?);
            let param = self.tables.at(&self.tables.params, subject.row.params().wrapping_add(k))?;
            if held && !self.in_domain(&param.domain(), value)? {
                return Err(Status::BadValue);
            }
            self.keep(number, value)?;
        }
        Ok(())
    }

    // ---- what comes in is held against the rules ----

    /// Whether no rule is broken, be it by what bit rows keep apart, by what kills would restore, or by what only a launch
    /// could break. Tables that are unchecked may hold rules that nothing can restore.
    fn keeps_rules(&mut self) -> Result<(), Status> {
        let mut broken = false;
        for request in 0..REQUESTS as Int {
            broken |= self.conflicts_broken(self.subject(request)?)?;
        }
        for rule in 0..RULES as Int {
            if let Some((_, node)) = self.walk(self.tables.at(&self.tables.rules, rule)?.root())? {
                broken |= node.action() == KILL || !self.unchecked();
            }
        }
        for invariant in 0..INVARIANTS as Int {
            broken |= self.walk(self.tables.at(&self.tables.invariants, invariant)?.root())?.is_some();
        }
        if broken { Err(Status::BrokenRule) } else { Ok(()) }
    }

    /// Whether what a bit row keeps apart from a request is active beside it.
    fn conflicts_broken(&self, subject: Subject<'t>) -> Result<bool, Status> {
        let own = (1 as Uint).wrapping_shl(subject.index as u32 & 15);
        if at(&self.active, subject.index >> 4).and_then(Cell::get)? & own == 0 {
            return Ok(false);
        }
        let mut broken = false;
        for block in self.tables.range(&self.tables.conflicts, subject.row.conflicts(), subject.row.conflicts_end())? {
            let mine = if block.block() == subject.index >> 4 { own } else { 0 };
            let mask = block.mask() as Uint & 0xffff;
            broken |= at(&self.active, block.block())?.get()? & mask & !mine != 0;
            broken |= mask & mine != 0 && at(&self.held, subject.index)?.get()? > 1;
        }
        Ok(broken)
    }
}
