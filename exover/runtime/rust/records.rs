//! The tables as the checker reads them: records of words, sections of records, and their checksum.

use crate::answers::Status;
use crate::tables::{self, Int, Uint, Word};

/// A record: words in the order of docs/runtime.md.
pub trait Record {
    /// How many words it has.
    const FIELDS: usize;
    /// How many records stand before those of its section.
    const BEFORE: usize;

    /// A word, and all of them added without carry.
    fn word(&self, field: usize) -> Option<Word>;
    fn sum(&self) -> Word;
}

/// Defines a record of the section `count` behind those before it, and for each of its words a method of that name.
macro_rules! record {
    ($name:ident $before:expr; $($field:ident)*) => {
        pub struct $name(pub [Word; [$(stringify!($field)),*].len()]);

        impl Record for $name {
            const FIELDS: usize = [$(stringify!($field)),*].len();
            const BEFORE: usize = before($before);

            fn word(&self, field: usize) -> Option<Word> {
                self.0.get(field).copied()
            }

            #[inline]
            fn sum(&self) -> Word {
                self.0.iter().fold(0, |sum, word| sum ^ word)
            }
        }

        record!(@ $name [] $($field)*);
    };
    (@ $name:ident [$($before:tt)*] $field:ident $($after:ident)*) => {
        impl $name {
            #[inline]
            #[allow(dead_code)] // a few words are read by nobody but the checksum
            pub fn $field(&self) -> Int {
                let [$($before)* word, ..] = self.0;
                Int::from(word)
            }
        }

        record!(@ $name [$($before)* _,] $($after)*);
    };
    (@ $name:ident [$($before:tt)*]) => {};
}

record!(NodeRow 0; code bound low high);
record!(EntryRow 1; initial rules rules_end sums sums_end);
record!(RequestRow 2; decide slots instances values interrupts_self statuses params results params_end orders orders_end
    features features_end pasts pasts_end consumes produces produces_end on_launch on_ok on_failed on_interrupted
    effects_end last conflicts conflicts_end);
record!(ParamRow 3; kind low high cuts cuts_end value rank);
record!(OrderRow 4; left right entry);
record!(FeatureRow 5; predicate slot weight running stopping waiting clearing);
record!(PastRow 6; predicate entry);
record!(AmountRow 7; stock amount predicate);
record!(EffectRow 8; kind target value);
record!(VariableRow 9; role kind low high initial has_fallback fallback cuts cuts_end value rank raw refresh refresh_end
    orders orders_end);
record!(LatchRow 10; variable condition resets resets_end);
record!(StockRow 11; capacity initial entry);
record!(RuleRow 12; root reason);
record!(LaunchRow 13; condition request args reason);
record!(LimitsRow 14; tests actions passes violations);
record!(ConflictRow 15; block mask);
record!(ReasonRow 16; denials);
record!(InvariantRow 17; root reason);
record!(SumRow 18; entry factor);
record!(ListRow 19; word);

/// How many records stand before those of a section, in the order of the bytes.
const fn before(section: usize) -> usize {
    let (mut sum, mut at, mut rest): (usize, usize, &[usize]) = (0, 0, &COUNTS);
    while let [count, others @ ..] = rest {
        if at == section {
            return sum;
        }
        sum = sum.wrapping_add(*count);
        at = at.wrapping_add(1);
        rest = others;
    }
    sum
}

pub const NONE: Int = -1; // no entry, no slot; as a node, the end of a path
pub const ALWAYS: Int = -2; // as a predicate: true of all arguments

// Actions of nodes: what stands in `code`, negated.
pub const REJECT: Int = 1;
pub const WAIT: Int = 2;
pub const CLEAR: Int = 3;
pub const SETTLE: Int = 4;
pub const KILL: Int = 5;
pub const DISMISS: Int = 6;
pub const LAUNCH: Int = 7;
pub const VIOLATION: Int = 8;

pub const REAL: Int = 3; // of types
pub const POSTER: Int = 0; // of roles
pub const SET: Int = 0; // of effects
pub const CLEARINGS: Int = 1; // of reasons
pub const ALL_DENIALS: Int = 2;

impl NodeRow {
    /// The action that this is; less than 1 for a test.
    pub fn action(&self) -> Int {
        self.code().wrapping_neg()
    }
}

impl RequestRow {
    pub fn arity(&self) -> Int {
        self.results().wrapping_sub(self.params())
    }
}

/// Of what type a value is, and in what range: of a real, indices of doubles.
pub struct Domain {
    pub kind: Int,
    pub low: Int,
    pub high: Int,
}

/// Where a value is put, so that diagrams can test it.
pub struct Gauge {
    pub real: bool,
    pub cuts: Int,
    pub cuts_end: Int,
    pub value: Int,
    pub rank: Int,
}

macro_rules! measured {
    ($name:ident) => {
        impl $name {
            pub fn domain(&self) -> Domain {
                Domain { kind: self.kind(), low: self.low(), high: self.high() }
            }

            pub fn gauge(&self) -> Gauge {
                let (cuts, cuts_end) = (self.cuts(), self.cuts_end());
                Gauge { real: self.kind() == REAL, cuts, cuts_end, value: self.value(), rank: self.rank() }
            }
        }
    };
}

measured!(ParamRow);
measured!(VariableRow);

/// The tables of a spec, as they were emitted.
pub struct Tables {
    pub(crate) head: [u32; 34],
    pub(crate) reals: [u64; tables::REALS],
    pub(crate) nodes: [NodeRow; tables::NODES],
    pub(crate) entries: [EntryRow; tables::ENTRIES],
    pub(crate) requests: [RequestRow; tables::REQUESTS],
    pub(crate) params: [ParamRow; tables::PARAMS],
    pub(crate) orders: [OrderRow; tables::ORDERS],
    pub(crate) features: [FeatureRow; tables::FEATURES],
    pub(crate) pasts: [PastRow; tables::PASTS],
    pub(crate) amounts: [AmountRow; tables::AMOUNTS],
    pub(crate) effects: [EffectRow; tables::EFFECTS],
    pub(crate) variables: [VariableRow; tables::VARIABLES],
    pub(crate) latches: [LatchRow; tables::LATCHES],
    pub(crate) stocks: [StockRow; tables::STOCKS],
    pub(crate) rules: [RuleRow; tables::RULES],
    pub(crate) launches: [LaunchRow; tables::LAUNCHES],
    pub(crate) limits: [LimitsRow; tables::LIMITS],
    pub(crate) conflicts: [ConflictRow; tables::CONFLICTS],
    pub(crate) reasons: [ReasonRow; tables::REASONS],
    pub(crate) invariants: [InvariantRow; tables::INVARIANTS],
    pub(crate) sums: [SumRow; tables::SUMS],
    pub(crate) lists: [ListRow; tables::LISTS],
    /// Of each record, then of each double: the complement of its words, added without carry.
    pub(crate) checks: [Word; tables::CHECKS],
}

const COUNTS: [usize; 20] = [
    tables::NODES,
    tables::ENTRIES,
    tables::REQUESTS,
    tables::PARAMS,
    tables::ORDERS,
    tables::FEATURES,
    tables::PASTS,
    tables::AMOUNTS,
    tables::EFFECTS,
    tables::VARIABLES,
    tables::LATCHES,
    tables::STOCKS,
    tables::RULES,
    tables::LAUNCHES,
    tables::LIMITS,
    tables::CONFLICTS,
    tables::REASONS,
    tables::INVARIANTS,
    tables::SUMS,
    tables::LISTS,
];

/// How far a checksum has come: the part of the tables (header, doubles, then the sections), and the number in it.
#[derive(Clone, Copy)]
pub struct Place {
    part: u32,
    at: u32,
    sum: u32,
}

impl Place {
    pub const START: Place = Place { part: 0, at: 0, sum: u32::MAX };
}

const LAST: u32 = 22;

impl Tables {
    /// Whether these are the tables that were emitted.
    pub(crate) fn check(&self) -> Result<(), Status> {
        let [magic, format, _, _, reals, ..] = self.head;
        let (_, counts) = self.head.split_at(13);
        if magic != 0x564f_5845 {
            return Err(Status::NoMagic); // "EXOV"
        }
        if format & 0xffff != 3 {
            return Err(Status::OtherFormat);
        }
        if format >> 16 != Word::BITS >> 3 {
            return Err(Status::OtherWidth);
        }
        let due = COUNTS.iter().chain([&tables::CHECKS]);
        if reals as usize != tables::REALS || counts.iter().zip(due).any(|(is, due)| *is as usize != *due) {
            return Err(Status::BadCounts);
        }
        let mut place = Place::START;
        while !self.add_number(&mut place).1 {}
        if self.is_sum(place) {
            Ok(())
        } else {
            Err(Status::BadChecksum)
        }
    }

    /// Whether a checksum of everything is right.
    pub(crate) fn is_sum(&self, place: Place) -> bool {
        let [_, _, _, checksum, ..] = self.head;
        !place.sum == tables::CHECKSUM && checksum == tables::CHECKSUM
    }

    /// Add the next number to a checksum: how many bytes it has, and whether all have been added.
    pub(crate) fn add_number(&self, place: &mut Place) -> (u32, bool) {
        if let Some((value, bytes)) = self.number(place.part, place.at as usize) {
            place.sum = crc(place.sum, value, bytes);
            place.at = place.at.wrapping_add(1);
            return (bytes, false);
        }
        if place.part >= LAST {
            return (0, true);
        }
        place.part = place.part.wrapping_add(1);
        place.at = 0;
        (0, false)
    }

    /// A number of a part, and its bytes; the checksum itself is taken as 0. None behind the last of the part.
    fn number(&self, part: u32, at: usize) -> Option<(u64, u32)> {
        let word = match part {
            0 => return self.head.get(at).map(|word| (if at == 3 { 0 } else { u64::from(*word) }, 4)),
            1 => return self.reals.get(at).map(|bits| (*bits, 8)),
            2 => word(&self.nodes, at),
            3 => word(&self.entries, at),
            4 => word(&self.requests, at),
            5 => word(&self.params, at),
            6 => word(&self.orders, at),
            7 => word(&self.features, at),
            8 => word(&self.pasts, at),
            9 => word(&self.amounts, at),
            10 => word(&self.effects, at),
            11 => word(&self.variables, at),
            12 => word(&self.latches, at),
            13 => word(&self.stocks, at),
            14 => word(&self.rules, at),
            15 => word(&self.launches, at),
            16 => word(&self.limits, at),
            17 => word(&self.conflicts, at),
            18 => word(&self.reasons, at),
            19 => word(&self.invariants, at),
            20 => word(&self.sums, at),
            21 => word(&self.lists, at),
            LAST => self.checks.get(at).copied(),
            _ => None,
        }?;
        Some((word as u64, Word::BITS >> 3))
    }
}

fn word<R: Record>(rows: &[R], at: usize) -> Option<Word> {
    rows.get(at.checked_div(R::FIELDS)?)?.word(at.checked_rem(R::FIELDS)?)
}

/// A CRC-32 (the one of Ethernet) with the lowest bytes of a number added.
pub(crate) fn crc(mut sum: u32, mut value: u64, bytes: u32) -> u32 {
    const NIBBLES: [u32; 16] = [
        0x0000_0000, 0x1db7_1064, 0x3b6e_20c8, 0x26d9_30ac, 0x76dc_4190, 0x6b6b_51f4, 0x4db2_6158, 0x5005_713c,
        0xedb8_8320, 0xf00f_9344, 0xd6d6_a3e8, 0xcb61_b38c, 0x9b64_c2b0, 0x86d3_d2d4, 0xa00a_e278, 0xbdbd_f21c,
    ];
    for _ in 0..bytes.wrapping_mul(2) {
        let nibble = (sum ^ value as u32) & 15;
        sum = NIBBLES.get(nibble as usize).map_or(0, |found| found ^ (sum >> 4));
        value >>= 4;
    }
    sum
}

/// An index as what arrays are indexed with: where it is negative, or too large for that, behind the end of all.
#[inline]
fn position(index: Int) -> usize {
    usize::try_from(index as Uint).unwrap_or(usize::MAX)
}

/// Record `index` of an array; no index is believed, since a bit may have changed after loading.
#[inline]
pub fn at<T>(rows: &[T], index: Int) -> Result<&T, Status> {
    rows.get(position(index)).ok_or(Status::FaultIndex)
}

#[inline]
pub fn at_mut<T>(rows: &mut [T], index: Int) -> Result<&mut T, Status> {
    rows.get_mut(position(index)).ok_or(Status::FaultIndex)
}

/// Values `from .. to` of an array.
#[inline]
pub fn range<T>(rows: &[T], from: Int, to: Int) -> Result<&[T], Status> {
    if from == to {
        return Ok(&[]);
    }
    rows.get(position(from)..position(to)).ok_or(Status::FaultIndex)
}

impl Tables {
    /// Whether a record with this sum is what was emitted: any one bit that has changed is found.
    #[inline]
    fn verify(&self, number: usize, sum: Word) -> Result<(), Status> {
        match self.checks.get(number) {
            Some(check) if *check ^ sum != -1 => Err(Status::FaultTables),
            None if tables::CHECKS > 0 => Err(Status::FaultIndex),
            _ => Ok(()),
        }
    }

    /// Record `index` of a section, compared with its check word.
    #[inline]
    pub(crate) fn at<'a, R: Record>(&self, rows: &'a [R], index: Int) -> Result<&'a R, Status> {
        let row = at(rows, index)?;
        self.verify(R::BEFORE.wrapping_add(position(index)), row.sum())?;
        Ok(row)
    }

    /// The records `from .. to` of a section, compared with their check words.
    #[inline]
    pub(crate) fn range<'a, R: Record>(&self, rows: &'a [R], from: Int, to: Int) -> Result<&'a [R], Status> {
        let found = range(rows, from, to)?;
        for (row, number) in found.iter().zip(R::BEFORE.wrapping_add(position(from))..) {
            self.verify(number, row.sum())?;
        }
        Ok(found)
    }

    /// A double, compared with its check word.
    pub(crate) fn real(&self, index: Int) -> Result<f64, Status> {
        let bits = *at(&self.reals, index)?;
        let mut sum: Word = 0;
        let mut left = 0;
        while left < 64 {
            sum ^= bits.wrapping_shr(left) as Word;
            left = left.wrapping_add(Word::BITS);
        }
        self.verify(before(COUNTS.len()).wrapping_add(position(index)), sum)?;
        Ok(f64::from_bits(bits))
    }
}

/// Where the value of a real poster is remembered.
pub fn raw(row: &VariableRow) -> Int {
    (tables::KEPT as Int).wrapping_add(row.raw())
}
