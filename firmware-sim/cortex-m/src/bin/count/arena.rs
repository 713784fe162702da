//! A memory arena that lends memory once and never takes it back.

use core::mem::MaybeUninit;

const BYTES: usize = 7 << 19;

#[repr(align(16))]
struct Memory {
    _bytes: MaybeUninit<[u8; BYTES]>,
}

static mut MEMORY: Memory = Memory { _bytes: MaybeUninit::uninit() };

/// The memory that is still free.
pub struct Arena {
    next: usize,
    end: usize,
}

impl Arena {
    /// Takes the whole arena; nothing lent before may be used any more.
    pub fn take() -> Self {
        let start = (&raw mut MEMORY) as usize;
        Arena { next: start, end: start + BYTES }
    }

    fn room<T>(&mut self, count: usize) -> *mut T {
        let start = self.next.next_multiple_of(align_of::<T>());
        self.next = start + count * size_of::<T>();
        assert!(self.next <= self.end, "the arena is too small");
        start as *mut T
    }

    /// A slice of `count` copies of a value.
    pub fn slice<T: Copy>(&mut self, count: usize, value: T) -> &'static mut [T] {
        let start = self.room::<T>(count);
        // SAFETY: aligned memory inside the arena, lent to nobody else.
        unsafe {
            (0..count).for_each(|i| start.add(i).write(value));
            core::slice::from_raw_parts_mut(start, count)
        }
    }

    /// A slice of an iterator's items.
    pub fn collect<T>(&mut self, items: impl Iterator<Item = T>) -> &'static mut [T] {
        let start = self.room::<T>(0);
        let mut count = 0;
        for item in items {
            let place = self.room::<T>(1);
            // SAFETY: as above; the items are contiguous.
            unsafe { place.write(item) };
            count += 1;
        }
        // SAFETY: `count` items have been written from `start` on.
        unsafe { core::slice::from_raw_parts_mut(start, count) }
    }

    /// One value.
    pub fn keep<T>(&mut self, value: T) -> &'static mut T {
        let place = self.room::<T>(1);
        // SAFETY: as above.
        unsafe {
            place.write(value);
            &mut *place
        }
    }
}
