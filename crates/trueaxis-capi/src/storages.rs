//! Every storage of the header with its content and its magic word.

use crate::opaque::{Storage, sizes};
use crate::{
    BranchTracker, CommandWindow, Encoder, Gauge, GaugeState, GaugeState512, Kinematics, Learned, Loop, Path, Program,
    Real, State, Thermal, ThermalTask, built, command_window, encoder, gauge, kinematics, spans,
};
use trueaxis::{learned, roundness, temperature};

/// Declares storages: name in messages, type in the header, content, number of its magic word.
macro_rules! storages {
    ($($name:literal $storage:ident: $content:ty = $number:literal;)*) => {
        $(
            // SAFETY: repr(C), one array of u64.
            unsafe impl Storage for $storage {
                type Content = $content;
                const MAGIC: u32 = 0x5452_0000 | $number;
            }
        )*

        const COUNT: usize = [$($name),*].len();

        // Numbers from 1 without a gap, so that no two storages have the same. The compiler evaluates it.
        #[allow(clippy::indexing_slicing)]
        const _: () = {
            let (numbers, mut i) = ([$($number),*], 0);
            while i < COUNT {
                assert!(numbers[i] == i as u32 + 1);
                i += 1;
            }
        };

        /// Name, bytes needed and bytes given of every storage, for the test of the sizes in the header.
        pub fn storage_sizes() -> [(&'static str, usize, usize); COUNT] {
            [$({
                let (needed, given) = sizes::<$storage>();
                ($name, needed, given)
            }),*]
        }
    };
}

storages! {
    "loop" Loop: built::Built = 1;
    "state" State: built::Running = 2;
    "path" Path: spans::Spans = 3;
    "gauge" Gauge: gauge::BuiltGauge = 4;
    "gauge state" GaugeState: roundness::GaugeState<Real, 1024> = 5;
    "gauge state 512" GaugeState512: roundness::GaugeState<Real, 512> = 6;
    "command window" CommandWindow: command_window::Commands = 7;
    "kinematics" Kinematics: kinematics::Chain = 8;
    "branch tracker" BranchTracker: trueaxis::kinematics::BranchTracker<Real> = 9;
    "program" Program: learned::ProgramId = 10;
    "learned" Learned: learned::Learned<'static, Real> = 11;
    "thermal" Thermal: temperature::Thermal<'static> = 12;
    "thermal task" ThermalTask: temperature::ThermalState = 13;
    "encoder" Encoder: encoder::Counted = 14;
}
