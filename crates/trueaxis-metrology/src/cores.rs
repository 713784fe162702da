//! Parallel iterators on all cores, by rayon. In a browser's module, which has one thread, the standard library's iterators
//! replace them under the same names.

#[cfg(not(target_family = "wasm"))]
pub use rayon::prelude::*;

#[cfg(target_family = "wasm")]
pub use alone::{Alone as _, Items as _, Parts as _};

#[cfg(target_family = "wasm")]
mod alone {
    /// Anything that can be iterated over.
    pub trait Items: IntoIterator + Sized {
        /// Returns the items in sequence.
        fn into_par_iter(self) -> Self::IntoIter {
            self.into_iter()
        }
    }

    impl<I: IntoIterator> Items for I {}

    /// Slices.
    pub trait Parts<T> {
        /// Returns the items in sequence.
        fn par_iter(&self) -> core::slice::Iter<'_, T>;
        /// Returns chunks of `size` items.
        fn par_chunks(&self, size: usize) -> core::slice::Chunks<'_, T>;
        /// Returns mutable chunks of `size` items.
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

    /// Methods of rayon's iterators that the standard library's lack.
    pub trait Alone: Iterator + Sized {
        /// Maps with a state that is created once.
        fn map_init<S, R>(
            self,
            init: impl FnOnce() -> S,
            each: impl Fn(&mut S, Self::Item) -> R,
        ) -> impl Iterator<Item = R> {
            let mut state = init();
            self.map(move |item| each(&mut state, item))
        }

        /// Flattens the iterators that `each` returns.
        fn flat_map_iter<I: IntoIterator>(self, each: impl FnMut(Self::Item) -> I) -> impl Iterator<Item = I::Item> {
            self.flat_map(each)
        }
    }

    impl<I: Iterator> Alone for I {}
}
