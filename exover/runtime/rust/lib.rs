//! The checker of an exover spec: asks, reports and readings in; launches, waits, rejections and kills out.
//!
//! `api.rs`, `names.rs` and `tables.rs` are made from the spec, the other files are the same for every spec. What a step means is
//! docs/language.md section 4; what the tables say, and what is found wrong how, is docs/runtime.md.
//!
//! ```ignore
//! let mut checker = Checker::new(&TABLES);
//! assert_eq!(checker.load(), Status::Ready);
//! for action in checker.ask(Request::NdGoto, &[3.0.into(), 4.0.into(), 0.5.into()]) {
//!     obey(action);
//! }
//! ```
//!
//! No heap, no recursion, no dependencies, no pointers but the one to the tables. Whatever goes wrong denies: after a
//! failed load or a fault every ask is answered by a rejection. Nothing panics: what clippy is told to deny here leaves
//! no index, no arithmetic and no unwrapping that could, whatever numbers the tables hold.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![deny(clippy::indexing_slicing, clippy::string_slice, clippy::arithmetic_side_effects)]
#![deny(clippy::panic, clippy::unreachable, clippy::todo, clippy::unimplemented)]
#![deny(clippy::unwrap_used, clippy::expect_used)]
// Words and the state are as wide as a spec needs, and it may need none of some records.
#![allow(clippy::unnecessary_cast, clippy::useless_conversion, clippy::unnecessary_fallible_conversions)]
#![allow(clippy::absurd_extreme_comparisons, clippy::reversed_empty_ranges)]

mod answers;
pub mod api;
mod blackbox;
mod cells;
mod checker;
mod decisions;
mod events;
mod features;
mod names;
mod recording;
mod records;
mod resume;
mod state;
mod tables;

pub use answers::{Action, Invalid, Outcome, Phase, Status, Value, View, Why};
pub use checker::Checker;
pub use names::{statuses, values, Poster, Reason, Request, Stock};
pub use records::Tables;
pub use tables::{ACTIONS, PASSES, RECORD_BYTES, SCRUB_STEPS, TABLES, TABLE_BYTES, TESTS};
