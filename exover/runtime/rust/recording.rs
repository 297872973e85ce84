//! What the checker writes to the black box: each event before it is decided, each answer before it is given.
//!
//! There with the feature `black-box`; without it nothing is kept and nothing is called.

use crate::answers::{Action, Value};
use crate::blackbox::What;
use crate::checker::Checker;

/// Of more values none is written, and they count as so many.
#[cfg(feature = "black-box")]
const MOST_VALUES: usize = 0xffff;

#[cfg(feature = "black-box")]
impl<'t> Checker<'t> {
    /// Record events and answers in this memory from now on, where it outlives a restart; false if the checker is faulty, or
    /// if there is no room for a line: 64 bytes, and 32 for each. What was written there for the same tables is kept.
    /// Bound: one look at every byte of the memory.
    pub fn record(&mut self, memory: &'t mut [u8]) -> bool {
        let [_, _, _, crc, _, a, b, c, d, e, f, g, h, ..] = self.tables.head;
        let opened = self.is_ready() && self.log.open(memory, crc, &[a, b, c, d, e, f, g, h]);
        if opened {
            self.log.line(self.steps(), What::Opened, 0, [0; 4]);
        }
        opened
    }

    /// A checker that records was loaded anew.
    pub(crate) fn reopened(&mut self) {
        if self.log.is_open() && self.is_ready() {
            self.log.line(self.steps(), What::Opened, 0, [0; 4]);
        }
    }

    fn is_ready(&self) -> bool {
        self.fault() == crate::answers::Status::Ready
    }

    /// Write an event, before anything is done with it.
    pub(crate) fn note(&mut self, what: What, words: [u32; 4], values: &[Value]) {
        fn halves(value: Option<&Value>) -> (u32, u32) {
            value.map_or((0, 0), |value| (value.bits() as u32, (value.bits() >> 32) as u32))
        }
        if self.log.is_open() {
            let step = self.steps().wrapping_add(1);
            self.log.line(step, what, values.len().min(MOST_VALUES) as u32, words);
            let told = if values.len() > MOST_VALUES { &[][..] } else { values };
            for pair in told.chunks(2) {
                let ((a, b), (c, e)) = (halves(pair.first()), halves(pair.get(1)));
                self.log.line(step, What::Values, pair.len() as u32, [a, b, c, e]);
            }
        }
    }

    /// Write the answers, before they are given.
    pub(crate) fn noted(&mut self) -> &[Action] {
        if self.log.is_open() {
            let (step, count) = (self.steps(), self.actions().len());
            for index in 0..count {
                if let Some((kind, words)) = self.actions().get(index).map(Action::words) {
                    self.log.line(step, What::Answer, kind, words);
                }
            }
            self.log.line(step, What::End, 0, [count as u32, self.fault() as u32, 0, 0]);
        }
        self.actions()
    }
}

#[cfg(not(feature = "black-box"))]
impl Checker<'_> {
    #[inline]
    pub(crate) fn reopened(&mut self) {}

    #[inline]
    pub(crate) fn note(&mut self, _: What, _: [u32; 4], _: &[Value]) {}

    #[inline]
    pub(crate) fn noted(&mut self) -> &[Action] {
        self.actions()
    }
}
