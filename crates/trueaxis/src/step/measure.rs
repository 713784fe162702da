//! References for the contour error.

#![deny(clippy::indexing_slicing)]

use super::model::Modelled;
use super::{ServoLoop, State};
use crate::axis::AXES;
use crate::contour::{
    CommandWindow, ContourError, ContourState, Flags, OnPath, OrientationError, Path, Reference, ToolPath,
};
use crate::kinematics::{Kinematics, Tool};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::telemetry::Record;
use crate::vector::V3;

/// Reference of the contour error: `()`, [`OnPath`], `&mut` [`CommandWindow`] or `&mut` [`OnToolPath`]. Implemented
/// for these types only, and resolved at compile time.
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
        state.forget_feet();
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
        record.set_feet(match points(sample, modelled) {
            Some([tip, encoder]) => servo.feet(state, &self.path, self.reference, tip, encoder),
            None => {
                // After a fault the last foot says nothing about the next one.
                state.forget_feet();
                [ContourError::none(); 2]
            }
        });
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
        if let ([x, y, z, ..], true) = (&sample.command[..], !sample.verdict.holds()) {
            self.append([*x, *y, *z]);
        }
        record.set_feet(match points(sample, modelled) {
            Some(points) => points.map(|point| self.contour_error(point)),
            None => [ContourError::none(); 2],
        });
    }

    #[inline(always)]
    fn take_back(&mut self) {
        self.restart();
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
            state.forget_feet();
            self.orientation = OrientationError::none();
            record.set_feet([ContourError::none(); 2]);
            return;
        }
        let kinematics = self.kinematics;
        let seen = servo.seen(&sample.feedback, modelled, kinematics);
        let [tip, encoder] = [seen.estimated.tip, seen.encoder].map(position::<R, P>);
        let [tip, encoder] = servo.feet(state, self.path.path(), self.reference, tip, encoder);
        let of_axes = |[a, b, c]: [R; 3]| kinematics.direction(&[R::ZERO, R::ZERO, R::ZERO, a, b, c]);
        self.orientation = self.path.orientation(self.reference, &tip, seen.estimated.axis, of_axes);
        let OrientationError { angle, flags, .. } = self.orientation;
        (record.tip, record.encoder) = (tip, encoder);
        (record.orientation, record.orientation_flags) = (angle, flags);
    }
}

/// Tip and direction as the model has them, tip by the encoders alone.
struct Seen<R: Real> {
    estimated: Tool<R>,
    encoder: R::Vec3,
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Feet of the estimated tip and of the plain encoder position.
    #[inline(always)]
    fn feet(
        &self,
        state: &mut State<R, P, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        tip: [P; 3],
        encoder: [P; 3],
    ) -> [ContourError<R>; 2] {
        if !reference.is_on_its_span() {
            return [(&mut state.tip, tip), (&mut state.encoder, encoder)]
                .map(|(state, point)| self.search.update_off(state, path, reference, &point));
        }
        let at_tip = self.search.update_on(&mut state.tip, path, reference, &tip);
        let at_encoder = self.search.update_on(&mut state.encoder, path, reference, &encoder);
        [at_tip, at_encoder]
    }

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
        let [tip, axis] = [tip, axis].map(V3::<R>::from_glam);
        let to_workpiece = |bed: V3<R>| V3::from_glam(kinematics.to_workpiece(&read, bed.glam()));
        let tilt = to_workpiece(modelled.tilt);
        let estimated = Tool { tip: (tip + to_workpiece(error)).glam(), axis: (axis + tilt.cross(axis)).glam() };
        Seen { estimated, encoder: plain.tip }
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

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// The next search starts cold.
    #[inline(always)]
    fn forget_feet(&mut self) {
        (self.tip, self.encoder) = (ContourState::default(), ContourState::default());
    }
}

/// The estimated tip and the plain encoder position; none while a reading is not believed.
#[inline(always)]
fn points<R: Real, P: Position, const N: usize>(
    sample: &Sample<P, N>,
    modelled: &Modelled<R, N>,
) -> Option<[[P; 3]; 2]> {
    let (true, [x, y, z, ..], [dx, dy, dz, ..]) =
        (matches!(sample.verdict, Verdict::Active | Verdict::Inactive), &sample.feedback[..], &modelled.tip_error[..])
    else {
        return None;
    };
    Some([[x.plus(*dx), y.plus(*dy), z.plus(*dz)], [*x, *y, *z]])
}

/// Workpiece coordinates as positions.
#[inline(always)]
fn position<R: Real, P: Position>(tip: R::Vec3) -> [P; 3] {
    let tip = V3::<R>::from_glam(tip);
    let zero = P::default();
    [zero.plus(tip.x), zero.plus(tip.y), zero.plus(tip.z)]
}
