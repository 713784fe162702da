//! References for the contour error.

#![deny(clippy::indexing_slicing)]

use super::model::Modelled;
use super::{ServoLoop, State};
use crate::axis::AXES;
use crate::contour::{CommandWindow, ContourError, Flags, OnPath, OrientationError, Reference, ToolPath};
use crate::kinematics::{Kinematics, Tool};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::telemetry::Record;
use crate::vector::V3;

/// Reference of the contour error: `()`, [`OnPath`], `&mut` [`CommandWindow`] or `&mut` [`OnToolPath`], resolved at compile
/// time, or `&mut dyn Measure` of one of them. Implemented for these types only.
#[allow(private_interfaces)]
pub trait Measure<R: Real, P: Position, const N: usize> {
    /// The model has to give the error of the tool's direction too.
    #[doc(hidden)]
    #[inline(always)]
    fn needs_tilt(&self) -> bool {
        false
    }
    /// The contour stage: writes both contour errors and the direction's into the record.
    #[doc(hidden)]
    fn measure(
        &mut self,
        servo: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    );
    /// The contour error of the tip in machine directions.
    #[doc(hidden)]
    #[inline(always)]
    fn in_machine(&self, _: &ServoLoop<'_, R, P, N>, _: &Sample<P, N>, error: R::Vec3) -> R::Vec3 {
        error
    }
    /// The command of this cycle was not sent.
    #[doc(hidden)]
    #[inline(always)]
    fn take_back(&mut self) {}
}

impl<R: Real, P, const N: usize> Record<R, P, N> {
    /// Contour errors of tip and encoder; the direction is not measured.
    #[inline(always)]
    fn set_feet(&mut self, [tip, encoder]: [ContourError<R>; 2]) {
        (self.tip, self.encoder) = (tip, encoder);
        (self.orientation, self.orientation_flags) = (R::ZERO, Flags::NOT_FOUND);
    }
}

#[allow(private_interfaces)]
impl<R: Real, P: Position, const N: usize> Measure<R, P, N> for () {
    #[inline(always)]
    fn measure(
        &mut self,
        _: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        _: &Sample<P, N>,
        _: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    ) {
        // A path that comes later is searched from the start.
        state.feet.forget();
        record.set_feet([ContourError::none(); 2]);
    }
}

#[allow(private_interfaces)]
impl<R: Real, P: Position, const N: usize> Measure<R, P, N> for OnPath<'_, R, P> {
    #[inline(always)]
    fn measure(
        &mut self,
        servo: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    ) {
        (record.orientation, record.orientation_flags) = (R::ZERO, Flags::NOT_FOUND);
        match points(sample, modelled) {
            Some((encoder, d)) => {
                servo.search.update_pair(&mut state.feet, self, encoder, d, &mut record.tip, &mut record.encoder);
            }
            None => {
                // After a fault the last foot says nothing about the next one.
                state.feet.forget();
                (record.tip, record.encoder) = (ContourError::none(), ContourError::none());
            }
        }
    }
}

/// The command of the first three axes, once the sample stage accepts it, is appended to the window, from which the
/// contour errors are taken. After homing call [`CommandWindow::restart`].
#[allow(private_interfaces)]
impl<R: Real, P: Position, const N: usize, const K: usize> Measure<R, P, N> for &mut CommandWindow<R, P, K> {
    #[inline(always)]
    fn measure(
        &mut self,
        _: &ServoLoop<'_, R, P, N>,
        _: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    ) {
        if let (&[x, y, z, ..], true) = (sample.command.as_slice(), !sample.verdict.holds()) {
            self.append([x, y, z]);
        }
        record.set_feet(match points(sample, modelled) {
            Some((encoder, d)) => {
                let ([x, y, z], [dx, dy, dz]) = (encoder, d);
                [[x.plus(*dx), y.plus(*dy), z.plus(*dz)], *encoder].map(|point| self.contour_error(point))
            }
            None => [ContourError::none(); 2],
        });
    }

    #[inline(always)]
    fn take_back(&mut self) {
        self.restart();
    }
}

/// Any of the others, chosen while it runs: one copy of the step for all of them, in which an absent part costs a call.
#[allow(private_interfaces)]
impl<R: Real, P: Position, const N: usize> Measure<R, P, N> for &mut (dyn Measure<R, P, N> + '_) {
    fn needs_tilt(&self) -> bool {
        (**self).needs_tilt()
    }

    fn measure(
        &mut self,
        servo: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    ) {
        (**self).measure(servo, state, sample, modelled, record);
    }

    fn in_machine(&self, servo: &ServoLoop<'_, R, P, N>, sample: &Sample<P, N>, error: R::Vec3) -> R::Vec3 {
        (**self).in_machine(servo, sample, error)
    }

    fn take_back(&mut self) {
        (**self).take_back();
    }
}

/// A tool path in workpiece coordinates, where on it the command of this cycle lies, and the machine's kinematics: the
/// tip's contour error and the direction's.
///
/// With q the raw feedback, F the forward transformation, e and w the modelled errors of tip and direction there (bed
/// axes; B turns them into the workpiece's), the estimated tool is
///
/// ```text
/// tip = F(q) + B e        direction = t + B w × t,   t = F(q)'s
/// ```
///
/// where in the nine-term form a rotary axis' own error belongs to q. The plain encoder position is the tip of F(q).
///
/// In single precision the absolute coordinates of F cost about 30 nm at 500 mm (half a unit in the last place of each of
/// its sums), and a rotary position up to 0.13 µrad; doubles nothing. One forward transformation (two in the nine-term
/// form) and one reference direction a cycle; beside a turn on the spot up to 26 more of the latter.
#[derive(Clone, Copy, Debug)]
pub struct OnToolPath<'a, R: Real, P> {
    path: &'a ToolPath<'a, R, P>,
    reference: Reference<R>,
    kinematics: &'a Kinematics<R>,
    orientation: OrientationError<R>,
}

impl<'a, R: Real, P: Position> OnToolPath<'a, R, P> {
    /// For one cycle.
    #[inline(always)]
    pub fn new(path: &'a ToolPath<'a, R, P>, reference: Reference<R>, kinematics: &'a Kinematics<R>) -> Self {
        OnToolPath { path, reference, kinematics, orientation: OrientationError::none() }
    }

    /// The orientation contour error of the cycle, whole; its angle is in the record.
    #[inline(always)]
    pub fn orientation(&self) -> &OrientationError<R> {
        &self.orientation
    }
}

#[allow(private_interfaces)]
impl<R: Real, P: Position, const N: usize> Measure<R, P, N> for &mut OnToolPath<'_, R, P> {
    #[inline(always)]
    fn needs_tilt(&self) -> bool {
        true
    }

    fn in_machine(&self, servo: &ServoLoop<'_, R, P, N>, sample: &Sample<P, N>, error: R::Vec3) -> R::Vec3 {
        self.kinematics.to_bed(&servo.joints(sample.feedback), error)
    }

    #[inline(always)]
    fn measure(
        &mut self,
        servo: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    ) {
        if !matches!(sample.verdict, Verdict::Active | Verdict::Inactive) {
            state.feet.forget();
            self.orientation = OrientationError::none();
            record.set_feet([ContourError::none(); 2]);
            return;
        }
        let kinematics = self.kinematics;
        let seen = servo.seen(sample.feedback, modelled, kinematics);
        let on = self.path.path().on(self.reference);
        let encoder = position::<R, P>(seen.encoder);
        servo.search.update_pair(&mut state.feet, &on, &encoder, &seen.off, &mut record.tip, &mut record.encoder);
        let tip = record.tip;
        let of_axes = |[a, b, c]: [R; 3]| kinematics.direction(&[R::ZERO, R::ZERO, R::ZERO, a, b, c]);
        self.orientation = self.path.orientation(self.reference, &tip, seen.axis, of_axes);
        let OrientationError { angle, flags, .. } = self.orientation;
        (record.orientation, record.orientation_flags) = (angle, flags);
    }
}

/// Direction as the model has it, tip by the encoders and by the model.
struct Seen<R: Real> {
    axis: R::Vec3,
    encoder: R::Vec3,
    /// Tip as the model has it, less that by the encoders.
    off: [R; 3],
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    #[inline(always)]
    fn seen(&self, feedback: &[P; N], modelled: &Modelled<R, N>, kinematics: &Kinematics<R>) -> Seen<R> {
        let read = self.joints(feedback);
        let mut actual = read;
        let mut moved = false;
        for (axis, error) in self.order.axes().iter().zip(&modelled.tip_error) {
            if let (true, Some(joint)) = (axis.is_rotary(), actual.get_mut(axis.index())) {
                *joint += *error;
                moved |= *error != R::ZERO;
            }
        }
        let plain = kinematics.forward(&read);
        let Tool { tip, axis } = if moved { kinematics.forward(&actual) } else { plain };
        let error = match &modelled.tip_error[..] {
            [x, y, z, ..] => V3::new(*x, *y, *z),
            _ => V3::ZERO,
        };
        let [tip, axis, encoder] = [tip, axis, plain.tip].map(V3::<R>::from_glam);
        let to_workpiece = |bed: V3<R>| V3::from_glam(kinematics.to_workpiece(&read, bed.glam()));
        let tilt = to_workpiece(modelled.tilt);
        let off = (tip - encoder) + to_workpiece(error);
        Seen { axis: (axis + tilt.cross(axis)).glam(), encoder: plain.tip, off: off.array() }
    }

    /// Positions of the step's axes in the order of the kinematics, rotary ones within ±180 degrees.
    #[inline(always)]
    pub(super) fn joints(&self, positions: &[P; N]) -> [R; AXES] {
        let zero = P::default();
        self.order.letters(positions, R::ZERO, |axis, position| {
            if axis.is_rotary() {
                let turn: R = position.turn_since(zero);
                // From the other side: an angle near 360 degrees would be rounded as that.
                if turn > R::of(180.0) { -zero.turn_since::<R>(*position) } else { turn }
            } else {
                position.since(zero)
            }
        })
    }
}

/// The plain encoder position, and what the estimated tip is away from it; none while a reading is not believed.
#[inline(always)]
fn points<'a, R: Real, P: Position, const N: usize>(
    sample: &'a Sample<P, N>,
    modelled: &'a Modelled<R, N>,
) -> Option<(&'a [P; 3], &'a [R; 3])> {
    let believed = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
    match (believed, sample.feedback.first_chunk(), modelled.tip_error.first_chunk()) {
        (true, Some(encoder), Some(d)) => Some((encoder, d)),
        _ => None,
    }
}

/// Workpiece coordinates as positions.
#[inline(always)]
fn position<R: Real, P: Position>(tip: R::Vec3) -> [P; 3] {
    let tip = V3::<R>::from_glam(tip);
    let zero = P::default();
    [zero.plus(tip.x), zero.plus(tip.y), zero.plus(tip.z)]
}
