//! The black box: the last events and answers in memory that is lent, as docs/runtime.md describes the bytes.
//!
//! There with the feature `black-box`; without it nothing is kept.

/// What a line says.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "black-box"), allow(dead_code))]
pub enum What {
    Opened = 1,
    Ask,
    Report,
    Observe,
    Level,
    Abort,
    AbortWaiting,
    Values,
    Answer,
    End,
}

#[cfg(feature = "black-box")]
mod memory {
    use super::What;
    use core::sync::atomic::{compiler_fence, Ordering::SeqCst};

    const HEADER: usize = 64;
    const LINE: usize = 32;
    const MAGIC: u32 = 0x5842_5845; // "EXBX"
    const FORMAT: u32 = 1;

    fn check_of(words: &[u32]) -> u32 {
        words.iter().fold(2_166_136_261, |sum: u32, word| (sum ^ word).wrapping_mul(16_777_619))
    }

    /// Write words, and behind them their check.
    fn write(bytes: &mut [u8], words: &[u32]) {
        let check = check_of(words);
        for (place, word) in bytes.chunks_exact_mut(4).zip(words.iter().chain(core::iter::once(&check))) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    fn word(bytes: &[u8], index: usize) -> Option<u32> {
        let four = bytes.chunks_exact(4).nth(index)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    }

    /// The number of a line, if it is whole.
    fn number(line: &[u8]) -> Option<u64> {
        let mut words = [0; 7];
        for (index, place) in words.iter_mut().enumerate() {
            *place = word(line, index)?;
        }
        let [low, _, what, ..] = words;
        let whole = word(line, 7)? == check_of(&words);
        whole.then_some(u64::from(low) | u64::from(what >> 24) << 32)
    }

    /// Where the memory is, and how far it is written, with the complement.
    pub struct BlackBox<'m> {
        memory: Option<&'m mut [u8]>,
        written: u64,
        unwritten: u64,
    }

    impl<'m> BlackBox<'m> {
        pub const CLOSED: BlackBox<'m> = BlackBox { memory: None, written: 0, unwritten: !0 };

        /// Keep what was written for the same tables in as many lines; else wipe it. False without room for a line.
        pub fn open(&mut self, memory: &'m mut [u8], crc: u32, digest: &[u32; 8]) -> bool {
            let count = memory.len().saturating_sub(HEADER) / LINE;
            let [a, b, c, d, e, f, g, h] = *digest;
            let lines = u32::try_from(count).unwrap_or(u32::MAX);
            let header = [MAGIC, FORMAT, lines, crc, a, b, c, d, e, f, g, h, 0, 0, 0];
            if count == 0 {
                return false;
            }
            let known = header.iter().copied().chain(core::iter::once(check_of(&header)));
            if !known.zip(0..).all(|(expected, index)| word(memory, index) == Some(expected)) {
                memory.fill(0);
                write(memory, &header);
            }
            self.memory = Some(memory);
            self.count(self.found());
            true
        }

        pub fn is_open(&self) -> bool {
            self.memory.is_some()
        }

        fn count(&mut self, written: u64) {
            self.written = written;
            self.unwritten = !written;
        }

        /// How many lines were ever written, as those say that are still there.
        fn found(&self) -> u64 {
            let memory = self.memory.as_deref().unwrap_or(&[]);
            let count = (memory.len().saturating_sub(HEADER) / LINE) as u64;
            let lines = memory.chunks_exact(LINE).skip(HEADER / LINE).map(number).zip(0..count);
            let in_place = |number: u64, place| number.wrapping_sub(1).checked_rem(count) == Some(place);
            lines.filter_map(|(line, place)| line.filter(|number| in_place(*number, place))).max().unwrap_or(0)
        }

        pub fn line(&mut self, step: u32, what: What, d: u32, words: [u32; 4]) {
            if self.written != !self.unwritten {
                self.count(self.found());
            }
            let (at, number) = (self.written, self.written.wrapping_add(1));
            self.count(number);
            let Some(memory) = self.memory.as_mut() else { return };
            let count = memory.len().saturating_sub(HEADER) / LINE;
            let place = usize::try_from(at.checked_rem(count as u64).unwrap_or(0)).unwrap_or(0);
            let [a, b, c, e] = words;
            let kind = what as u32 | (d & 0xffff) << 8 | ((number >> 32) as u32) << 24;
            if let Some(line) = memory.chunks_exact_mut(LINE).nth(place.saturating_add(HEADER / LINE)) {
                write(line, &[number as u32, step, kind, a, b, c, e]);
            }
            compiler_fence(SeqCst);
        }
    }
}

#[cfg(feature = "black-box")]
pub use memory::BlackBox;
