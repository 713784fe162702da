//! Contour errors: reported when measured, on the path, consistent; the window of commands.

use super::{Contract, Seen, Verdict};
use crate::walk::combination::Measured;
use crate::walk::device::SPACING_MM;
use crate::walk::rule::{Broken, Rule};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::Fault;
use trueaxis::contour::{ContourError, Flags, Path};
use trueaxis::telemetry::{Record, Status};

/// Maximum number of evaluations of the path in a cycle, and of the window of commands.
const EVALUATIONS: [u8; 2] = [4, 8];
/// Distance from the path, mm, beyond which integers saturate and single precision is too coarse.
const FAR_MM: f64 = 1000.0;

/// State of the window after the previous cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WindowMemory {
    /// Number of the newest span.
    newest: Option<u32>,
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// Checks every cycle.
    pub(super) fn measured(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let measured = seen.moment.measured;
        let agrees = record.status.has(Status::CONTOUR) == record.tip.is_measured();
        let plausible = matches!(verdict, Verdict::Active | Verdict::Inactive) && measured != Measured::Nothing;
        // The joint's range is checked after the error was measured.
        let may = plausible || record.fault == Fault::JointRange && measured != Measured::Nothing;
        let found = || format!("{:?}, {verdict:?}: {:?}, {:?}", record.status, record.tip, record.encoder);
        let none = !record.tip.is_measured() && !record.encoder.is_measured();
        self.tally.that(Rule::ContourReported, agrees && (may || none), found)?;
        let most = EVALUATIONS[usize::from(measured == Measured::Window)];
        self.consistent(&record.tip, most)?;
        self.consistent(&record.encoder, most)?;
        self.orientation(seen)?;
        match measured {
            Measured::Path => {
                self.settled(&record.tip)?;
                self.settled(&record.encoder)?;
                self.on_path(seen, &seen.ground.path())
            }
            Measured::Window => self.window(seen, verdict, first),
            _ => Ok(()),
        }
    }

    fn consistent(&mut self, error: &ContourError<R>, most: u8) -> Result<(), Broken> {
        let [x, y, z] = error.vector.into().map(R::to_f64);
        let (length, reported) = ((x * x + y * y + z * z).sqrt(), error.error.to_f64());
        let near = (length - reported).abs() <= 1e-9 + 4.0 * R::EPSILON.to_f64() * length;
        let inside = error.t >= R::ZERO && error.t <= R::ONE;
        let bounded = error.evaluations <= most && error.width >= R::ZERO && reported >= 0.0;
        let empty = error.is_measured() || length == 0.0 && error.lag == R::ZERO;
        let holds = near && inside && bounded && empty;
        self.tally.that(Rule::ContourConsistent, holds, || format!("{error:?}"))
    }

    /// An error is measured from a foot, or the search for it continues.
    fn settled(&mut self, error: &ContourError<R>) -> Result<(), Broken> {
        let [bracketed, searching] = [Flags::BRACKETED, Flags::SEARCHING].map(|flag| error.flags.has(flag));
        let holds = !error.is_measured() || bracketed != searching;
        self.tally.that(Rule::ContourConsistent, holds, || format!("{error:?}"))
    }

    fn orientation(&mut self, seen: &Seen<'_, '_, R, P, N>) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let angle = record.orientation.to_f64();
        let silent = record.orientation_flags == Flags::NOT_FOUND && angle == 0.0;
        let sound = (0.0..=1.0001 * std::f64::consts::PI).contains(&angle);
        let holds = sound && (silent || seen.moment.measured == Measured::ToolPath);
        let found = || format!("{angle}, {:?}, {:?}", record.orientation_flags, seen.moment.measured);
        self.tally.that(Rule::Orientation, holds, found)
    }

    /// Checks that the encoder's foot is at the reported span and parameter.
    fn on_path(&mut self, seen: &Seen<'_, '_, R, P, N>, path: &Path<'_, R, P>) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let error = &record.encoder;
        let Some(span) = path.span(error.span).filter(|_| error.is_measured()) else { return Ok(()) };
        // The search finds the encoder's foot from the tip's. Far away, single precision is too coarse for that.
        let size = error.error.to_f64() + record.tip.error.to_f64();
        if size > FAR_MM {
            return Ok(());
        }
        let foot = span.position(error.t);
        let vector = error.vector.into().map(R::to_f64);
        for k in 0..3 {
            let (reading, foot) = (record.feedback[k].to_f64(), foot[k].to_f64());
            let rounding = 1e-9 + 2.0 * P::GRAIN + R::EPSILON.to_f64() * (64.0 + 8.0 * size);
            // A foot beyond the range of integers is reported at its end.
            if P::GRAIN > 0.0 && foot.abs() >= P::GRAIN * f64::from(i32::MAX) {
                continue;
            }
            let off = reading - vector[k] - foot;
            let rounding = rounding + 1e-15 * reading.abs();
            self.tally
                .that(Rule::FootOnPath, off.abs() <= rounding, || format!("{off} mm along {k}: {error:?} {span:?}"))?;
        }
        Ok(())
    }

    fn window(&mut self, seen: &Seen<'_, '_, R, P, N>, verdict: Verdict, first: bool) -> Result<(), Broken> {
        let window = &seen.device.window;
        let path = window.path();
        if verdict.holds() || first {
            self.window.newest = None;
            return Ok(());
        }
        let at = window.reference();
        let Some(newest) = path.span(at.span) else {
            return self.tally.that(Rule::WindowEnds, false, || "no span after a command".into());
        };
        let (end, command) = (newest.position(at.t), &seen.moment.input.command);
        let off = (0..3).map(|k| (end[k].to_f64() - command[k].to_f64()).abs()).fold(0.0, f64::max);
        let size = command[..3].iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        // Within a 250th of the spacing a command counts as being at the last point; a 200th is tolerated.
        let near = off <= SPACING_MM / 200.0 + 4.0 * P::GRAIN + 64.0 * R::EPSILON.to_f64() + 1e-15 * size;
        self.tally.that(Rule::WindowEnds, near, || format!("{off} mm from {command:?}"))?;
        if let Some(before) = path.span(at.span.wrapping_sub(1)) {
            let joint = before.position(R::ONE);
            let start = newest.position(R::ZERO);
            let off = (0..3).map(|k| (joint[k].to_f64() - start[k].to_f64()).abs()).fold(0.0, f64::max);
            let near = off <= 4.0 * P::GRAIN + 64.0 * R::EPSILON.to_f64() + 1e-15 * size;
            self.tally.that(Rule::WindowJoined, near, || format!("{off} mm at span {}", at.span))?;
        }
        // At most one further per cycle; one back if a command returns to the last point.
        let number = at.span;
        let ordered = self.window.newest.is_none_or(|last| number.wrapping_sub(last).wrapping_add(1) <= 3);
        self.tally.that(Rule::WindowJoined, ordered, || format!("{number} after {:?}", self.window.newest))?;
        self.window.newest = Some(number);
        self.nearest(seen, &path, &end)?;
        self.on_path(seen, &path)
    }

    /// Checks that the newest command is on the path, and that no nearer point is skipped.
    fn nearest(&mut self, seen: &Seen<'_, '_, R, P, N>, path: &Path<'_, R, P>, end: &[P; 3]) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let error = &record.encoder;
        if !error.is_measured() {
            return Ok(());
        }
        let squares = (0..3).map(|k| {
            let off = record.feedback[k].to_f64() - end[k].to_f64();
            off * off
        });
        let distance = squares.sum::<f64>().sqrt();
        if distance > FAR_MM {
            return Ok(());
        }
        let rounding = 1e-5 + R::EPSILON.to_f64() * (64.0 + 16.0 * distance);
        // Chords decide which of two spans is nearer to the tip, and the chord of an arc that turns by 40 degrees is
        // off by a ninth. The search for the encoder's foot starts from the tip's.
        let chord = path.span(error.span).map_or(0.0, |span| span.length().to_f64());
        let allowed = distance + chord / 9.0 + 2.0 * apart(record, path) + rounding;
        let holds = error.error.to_f64() <= allowed;
        self.tally.that(Rule::WindowNearest, holds, || format!("{distance} mm to the newest command, {error:?}"))
    }
}

/// Distance between the positions of encoder and tip, mm.
fn apart<R: Scalar, P: Place, const N: usize>(record: &Record<R, P, N>, path: &Path<'_, R, P>) -> f64 {
    let tip = &record.tip;
    let Some(span) = path.span(tip.span).filter(|_| tip.is_measured()) else { return 0.0 };
    let (foot, vector) = (span.position(tip.t), tip.vector.into().map(R::to_f64));
    let off = (0..3).map(|k| foot[k].to_f64() + vector[k] - record.feedback[k].to_f64());
    off.map(|off| off * off).sum::<f64>().sqrt()
}
