//! Numbers by which tables are told from others, so that nothing kept from one look-up is used in the other's.

/// A hash of words and numbers in their order.
pub(super) struct Key(pub(super) u64);

impl Key {
    pub(super) fn add(&mut self, word: u64) {
        self.0 = mixed(self.0 ^ word);
    }

    pub(super) fn add_number(&mut self, number: f64) {
        self.add(number.to_bits());
    }

    pub(super) fn add_all<'x>(&mut self, numbers: impl IntoIterator<Item = &'x f64>) {
        numbers.into_iter().for_each(|number| self.add_number(*number));
    }
}

/// Every bit of the result depends on all bits of `x` (splitmix64's finish).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
