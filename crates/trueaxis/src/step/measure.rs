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
    /// Whether the model must also give the error of the tool's direction.
    #[doc(hidden)]
    #[inline(always)]
    fn needs_tilt(&self) -> bool {
        false
    }
    /// Contour stage: writes both contour errors and the direction error into the record.
    #[doc(hidden)]
    fn measure(
        &mut self,
        servo: &ServoLoop<'_, R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        record: &mut Record<R, P, N>,
    );
    /// Converts the contour error of the tip to machine directions.
    #[doc(hidden)]
    #[inline(always)]
    fn in_machine(&self, _: &ServoLoop<'_, R, P, N>, _: &Sample<P, N>, error: R::Vec3) -> R::Vec3 {
        error
    }
    /// Takes back the command of this cycle, which was not sent.
    #[doc(hidden)]
    #[inline(always)]
    fn take_back(&mut self) {}
}

impl<R: Real, P, const N: usize> Record<R, P, N> {
    /// Sets the contour errors of tip and encoder; the direction is not measured.
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
        // A path that is set later is searched from its start.
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
                // After a fault the last foot point gives no start for the next search.
                state.feet.forget();
                (record.tip, record.encoder) = (ContourError::none(), ContourError::none());
            }
        }
    }
}

/// Appends the command of the first three axes to the window once the sample stage accepts it; the contour errors are
/// measured from the window. Call [`CommandWindow::restart`] after homing.
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

/// Any implementation, chosen at run time: one copy of the step serves all of them, in which an absent part costs a call.
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

/// A tool path in workpiece coordinates, the command's place on it in this cycle, and the machine's kinematics: measures
/// the contour errors of tip and direction.
///
/// With q the raw feedback, F the forward transformation, e and w the modelled errors of tip and direction there (in bed
/// axes; B rotates them into the workpiece's), the estimated tool is
///
/// ```text
/// tip = F(q) + B e        direction = t + B w × t,   t = F(q)'s
/// ```
///
/// and in the nine-term form the error of a rotary axis is part of q. The plain encoder position is the tip of F(q).
///
/// In single precision the absolute coordinates of F cost about 30 nm at 500 mm (half a unit in the last place of each of
/// its sums), and a rotary position up to 0.13 µrad; doubles cost nothing. Each cycle takes one forward transformation
/// (two in the nine-term form) and one reference direction, and up to 26 more of the latter near a turn on the spot.
#[derive(Clone, Copy, Debug)]
pub struct OnToolPath<'a, R: Real, P> {
    path: &'a ToolPath<'a, R, P>,
    reference: Reference<R>,
    kinematics: &'a Kinematics<R>,
    orientation: OrientationError<R>,
}

impl<'a, R: Real, P: Position> OnToolPath<'a, R, P> {
    /// Binds path, reference and kinematics for one cycle.
    #[inline(always)]
    pub fn new(path: &'a ToolPath<'a, R, P>, reference: Reference<R>, kinematics: &'a Kinematics<R>) -> Self {
        OnToolPath { path, reference, kinematics, orientation: OrientationError::none() }
    }

    /// The full orientation contour error of the cycle; the record contains its angle.
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

/// Modelled direction, tip by the encoders, and modelled tip.
struct Seen<R: Real> {
    axis: R::Vec3,
    encoder: R::Vec3,
    /// Modelled tip − tip by the encoders.
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
                // Subtracted in the opposite order: an angle near 360 degrees would be rounded with the error of 360.
                if turn > R::of(180.0) { -zero.turn_since::<R>(*position) } else { turn }
            } else {
                position.since(zero)
            }
        })
    }
}

/// The plain encoder position and the offset of the estimated tip from it; `None` while a reading is not trusted.
#[inline(always)]
fn points<'a, R: Real, P: Position, const N: usize>(
    sample: &'a Sample<P, N>,
    modelled: &'a Modelled<R, N>,
) -> Option<(&'a [P; 3], &'a [R; 3])> {
    let plausible = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
    match (plausible, sample.feedback.first_chunk(), modelled.tip_error.first_chunk()) {
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
