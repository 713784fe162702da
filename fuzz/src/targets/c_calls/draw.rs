//! Decisions drawn from the bytes of the input.

/// The rest of the input; every byte beyond its end is zero.
pub(super) struct Draw<'b> {
    rest: &'b [u8],
}

/// Numbers at which the behaviour may change.
const SPECIAL: [f64; 24] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e-3,
    -1e-9,
    1e-300,
    5e-324,
    1e9,
    -1e9,
    1.000_000_1e9,
    1e12,
    f64::MAX,
    f64::MIN,
    400.0,
    -400.0,
    401.0,
    360.0,
    90.0,
    0.02,
];

impl<'b> Draw<'b> {
    pub(super) fn new(rest: &'b [u8]) -> Self {
        Draw { rest }
    }

    pub(super) fn is_over(&self) -> bool {
        self.rest.is_empty()
    }

    pub(super) fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.rest.split_first() else { return 0 };
        self.rest = rest;
        *first
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    pub(super) fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    pub(super) fn word(&mut self) -> u32 {
        u32::from_le_bytes([(); 4].map(|()| self.byte()))
    }

    /// A number, usually a small one, sometimes any.
    pub(super) fn number(&mut self) -> f64 {
        match self.byte() {
            0..128 => f64::from(self.byte() as i8),
            128..208 => f64::from(i16::from_le_bytes([self.byte(), self.byte()])) / 64.0,
            208..248 => SPECIAL[self.below(SPECIAL.len())],
            _ => f64::from_bits(u64::from_le_bytes([(); 8].map(|()| self.byte()))),
        }
    }

    pub(super) fn numbers<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| self.number())
    }

    /// Selects a defect in the pointers of the next call, usually none.
    pub(super) fn wrong(&mut self) -> Wrong {
        let byte = self.byte();
        let kind = match byte {
            0..200 => return Wrong { kind: Kind::Nothing, argument: 0, met: false },
            200..220 => Kind::Null,
            220..238 => Kind::Odd,
            _ => Kind::Size,
        };
        Wrong { kind, argument: self.below(6) as u8, met: false }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Nothing,
    Null,
    /// Misaligned.
    Odd,
    Size,
}

/// One argument of a call that violates the header.
pub(super) struct Wrong {
    kind: Kind,
    argument: u8,
    /// Whether the call has such an argument, so that it must refuse.
    pub(super) met: bool,
}

impl Wrong {
    fn is(&mut self, kind: Kind, argument: u8) -> bool {
        let met = self.kind == kind && self.argument == argument;
        self.met |= met;
        met
    }

    /// The pointer of an argument: unchanged, null, or one byte off.
    pub(super) fn at<T>(&mut self, argument: u8, pointer: *mut T) -> *mut T {
        if self.is(Kind::Null, argument) {
            std::ptr::null_mut()
        } else if align_of::<T>() > 1 && self.is(Kind::Odd, argument) {
            pointer.wrapping_byte_add(1)
        } else {
            pointer
        }
    }

    /// Like [`at`](Wrong::at), for an argument that may be null: `None`.
    pub(super) fn or_null<T>(&mut self, argument: u8, pointer: Option<*mut T>) -> *mut T {
        match pointer {
            None => std::ptr::null_mut(),
            Some(pointer) if self.kind == Kind::Null => pointer,
            Some(pointer) => self.at(argument, pointer),
        }
    }

    /// Memory that must be aligned to eight bytes.
    pub(super) fn memory(&mut self, argument: u8, memory: &mut [u64]) -> *mut std::ffi::c_void {
        self.at(argument, memory.as_mut_ptr()).cast()
    }

    /// The size of an argument.
    pub(super) fn size(&mut self, argument: u8, size: usize) -> usize {
        if self.is(Kind::Size, argument) { size - 4 } else { size }
    }
}
