//! Work on all cores: rayon's iterators. A browser's module has one thread; there they are those of the standard library under
//! the same names, and rayon stays out of it.

#[cfg(not(target_family = "wasm"))]
pub use rayon::prelude::*;

#[cfg(target_family = "wasm")]
pub use alone::{Alone as _, Items as _, Parts as _};

#[cfg(target_family = "wasm")]
mod alone {
    /// Whatever can be iterated over.
    pub trait Items: IntoIterator + Sized {
        /// Its items, one after the other.
        fn into_par_iter(self) -> Self::IntoIter {
            self.into_iter()
        }
    }

    impl<I: IntoIterator> Items for I {}

    /// Slices.
    pub trait Parts<T> {
        /// Its items, one after the other.
        fn par_iter(&self) -> core::slice::Iter<'_, T>;
        /// Parts of so many items.
        fn par_chunks(&self, size: usize) -> core::slice::Chunks<'_, T>;
        /// The same to be written.
        fn par_chunks_mut(&mut self, size: usize) -> core::slice::ChunksMut<'_, T>;
    }

    impl<T> Parts<T> for [T] {
        fn par_iter(&self) -> core::slice::Iter<'_, T> {
            self.iter()
        }

        fn par_chunks(&self, size: usize) -> core::slice::Chunks<'_, T> {
            self.chunks(size)
        }

        fn par_chunks_mut(&mut self, size: usize) -> core::slice::ChunksMut<'_, T> {
            self.chunks_mut(size)
        }
    }

    /// What rayon's iterators have beside those of the standard library.
    pub trait Alone: Iterator + Sized {
        /// `each` with a state that is made once.
        fn map_init<S, R>(
            self,
            init: impl FnOnce() -> S,
            each: impl Fn(&mut S, Self::Item) -> R,
        ) -> impl Iterator<Item = R> {
            let mut state = init();
            self.map(move |item| each(&mut state, item))
        }

        /// All items that `each` gives.
        fn flat_map_iter<I: IntoIterator>(self, each: impl FnMut(Self::Item) -> I) -> impl Iterator<Item = I::Item> {
            self.flat_map(each)
        }
    }

    impl<I: Iterator> Alone for I {}
}
