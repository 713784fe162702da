//! One record per evaluated revolution.

use crate::real::Real;
use crate::roundness::{Counts, ErrorMotion, Evaluation, Gauge, GaugeFlags, GaugeState, HARMONICS};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the layout that [`RoundnessFrame`] writes; distinct from the versions of [`super::Frame`], so that a
/// receiver can distinguish the two kinds by their first byte.
pub const ROUNDNESS_FRAME_VERSION: u8 = 129;
/// Buffer size sufficient for the COBS frame of any revolution.
pub const ROUNDNESS_FRAME_BYTES: usize = 1280;

/// Wire form of the results of a revolution: identical layout in every build; its members are in `docs/telemetry.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RoundnessFrame {
    /// Layout of this record; [`ROUNDNESS_FRAME_VERSION`].
    #[doc(hidden)]
    pub version: u8,
    /// Identity of the machine.
    #[doc(hidden)]
    pub machine_id: u32,
    /// Counter of completely sampled revolutions, from 1, wrapping.
    #[doc(hidden)]
    pub revolution: u32,
    /// Revolutions evaluated so far.
    #[doc(hidden)]
    pub evaluated: u32,
    /// Completely skipped revolutions so far.
    #[doc(hidden)]
    pub skipped: u32,
    /// Completely discarded revolutions so far.
    #[doc(hidden)]
    pub discarded: u32,
    /// Events of this revolution.
    #[doc(hidden)]
    pub flags: GaugeFlags,
    /// Peak-to-valley roundness about the least-squares circle, µm.
    #[doc(hidden)]
    pub peak_to_valley_um: f32,
    /// Revolutions in the window of the error motions; 0 until a window is full.
    #[doc(hidden)]
    pub revolutions: u16,
    /// Error motion along X.
    #[doc(hidden)]
    pub x: ErrorMotion<f32>,
    /// Error motion along Y.
    #[doc(hidden)]
    pub y: ErrorMotion<f32>,
    /// First harmonic of the list below.
    #[doc(hidden)]
    pub first_harmonic: u16,
    /// Amplitudes of cos kθ and sin kθ, µm, for the stored part of the band (k <= 127).
    #[doc(hidden)]
    pub harmonics: Vec<[f32; 2], HARMONICS>,
}

impl RoundnessFrame {
    /// Converts the latest revolution to its wire form; `None` before the first. Not part of the step; call it while the
    /// state is settled: once work on the next revolution has begun, some of the state belongs to that one.
    pub fn of<R: Real, const POINTS: usize>(
        machine_id: u32,
        gauge: &Gauge<R, POINTS>,
        state: &GaugeState<R, POINTS>,
    ) -> Option<RoundnessFrame> {
        let Evaluation { revolution, flags, peak_to_valley_um, x, y, revolutions } = state.latest()?;
        let Counts { evaluated, skipped, discarded, .. } = state.counts();
        let single = |x: R| x.to_f64() as f32;
        let motion = |motion: ErrorMotion<R>| ErrorMotion {
            synchronous_um: single(motion.synchronous_um),
            asynchronous_um: single(motion.asynchronous_um),
            once_per_revolution_um: motion.once_per_revolution_um.map(single),
            total_um: single(motion.total_um),
        };
        let band = gauge.band();
        let last = usize::from(band.last).min(HARMONICS - 1);
        Some(RoundnessFrame {
            version: ROUNDNESS_FRAME_VERSION,
            machine_id,
            revolution,
            evaluated,
            skipped,
            discarded,
            flags,
            peak_to_valley_um: single(peak_to_valley_um),
            revolutions,
            x: motion(x),
            y: motion(y),
            first_harmonic: band.first,
            harmonics: (usize::from(band.first)..=last).map(|k| state.harmonic(k).map(single)).collect(),
        })
    }

    /// Encodes into `buffer`; returns the part used, its last byte zero.
    ///
    /// # Errors
    /// The buffer is smaller than the frame ([`ROUNDNESS_FRAME_BYTES`] always suffice).
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b mut [u8], postcard::Error> {
        postcard::to_slice_cobs(self, buffer)
    }

    /// Decodes one frame, with or without its closing zero byte; `bytes` is scratch afterwards.
    ///
    /// # Errors
    /// The bytes are not one whole frame, or its version is not [`ROUNDNESS_FRAME_VERSION`].
    pub fn decode(bytes: &mut [u8]) -> Result<RoundnessFrame, postcard::Error> {
        let frame: RoundnessFrame = postcard::from_bytes_cobs(bytes)?;
        let known = frame.version == ROUNDNESS_FRAME_VERSION;
        if known { Ok(frame) } else { Err(postcard::Error::DeserializeBadEncoding) }
    }
}
