//! A map from whole-number coordinates to numbers in order of arrival.

/// Open-addressing hash table; cleared in no time.
pub struct Table<const D: usize> {
    entries: Vec<Entry<D>>,
    count: u32,
    round: u32,
}

#[derive(Clone, Copy)]
struct Entry<const D: usize> {
    key: [i32; D],
    slot: u32,
    round: u32,
}

impl<const D: usize> Default for Table<D> {
    fn default() -> Self {
        Self { entries: vec![Entry { key: [0; D], slot: 0, round: 0 }; 64], count: 0, round: 1 }
    }
}

impl<const D: usize> Table<D> {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.count = 0;
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.entries.iter_mut().for_each(|e| e.round = 0);
            self.round = 1;
        }
    }

    /// Where `key` is or would go.
    fn place(&self, key: [i32; D]) -> usize {
        let mask = self.entries.len() - 1;
        let mut hash = 0u64;
        for k in key {
            hash = (hash ^ k as u32 as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            hash ^= hash >> 29;
        }
        let mut at = hash as usize & mask;
        while self.entries[at].round == self.round && self.entries[at].key != key {
            at = (at + 1) & mask;
        }
        at
    }

    /// Number of `key`, if it has come.
    pub fn find(&self, key: [i32; D]) -> Option<u32> {
        let e = &self.entries[self.place(key)];
        (e.round == self.round).then_some(e.slot)
    }

    /// Number of `key`, and whether it is new.
    pub fn slot(&mut self, key: [i32; D]) -> (u32, bool) {
        let at = self.place(key);
        if self.entries[at].round == self.round {
            return (self.entries[at].slot, false);
        }
        let slot = self.count;
        self.entries[at] = Entry { key, slot, round: self.round };
        self.count += 1;
        if 2 * self.count as usize > self.entries.len() {
            self.grow();
        }
        (slot, true)
    }

    fn grow(&mut self) {
        let empty = Entry { key: [0; D], slot: 0, round: 0 };
        let old = std::mem::take(&mut self.entries);
        self.entries = vec![empty; 2 * old.len()];
        for e in old.into_iter().filter(|e| e.round == self.round) {
            let at = self.place(e.key);
            self.entries[at] = e;
        }
    }
}
