//! Whatever bits come in, every number that goes out is finite.

use super::*;
use crate::contour::{CommandWindow, Flags, Segment, Span, convert};
use crate::position::Nanometres;
use crate::telemetry::Frame;
use glam::DVec3;

/// A line, a quarter circle, a line.
fn spans<R: Real, P: Position>() -> Vec<Span<R, P>> {
    let segments = [
        Segment::Line { start: DVec3::new(10.0, 10.0, 10.0), end: DVec3::new(50.0, 10.0, 10.0) },
        Segment::Arc {
            start: DVec3::new(50.0, 10.0, 10.0),
            end: DVec3::new(60.0, 20.0, 10.0),
            center: DVec3::new(50.0, 20.0, 10.0),
            normal: DVec3::new(0.0, 0.0, 1.0),
            turns: 0,
        },
        Segment::Line { start: DVec3::new(60.0, 20.0, 10.0), end: DVec3::new(60.0, 90.0, 10.0) },
    ];
    let mut spans = Vec::new();
    for (segment, number) in segments.iter().zip(0..) {
        convert(segment, number, [0.0, 0.0, 1.0], |span: Span<f64, f64>| {
            spans.push(span.rounded());
            Ok(())
        })
        .unwrap();
    }
    spans
}

/// Bits of a cycle: values that are not used as they are stay near the machine's position.
type Bits = ([f64; 3], [f64; 3], f64, u32, u32, u16);

fn any_bits() -> impl Strategy<Value = Bits> {
    let t = prop_oneof![3 => 0.0..=1.0f64, 2 => -0.5..1.5f64, 2 => any_float()];
    let elapsed = prop_oneof![3 => Just(PERIOD_NS), 1 => any::<u32>(), 1 => 0..2_000_000u32];
    let span = prop_oneof![4 => 0..20u32, 1 => any::<u32>()];
    ([any_float(), any_float(), any_float()], [any_float(), any_float(), any_float()], t, span, elapsed, any::<u16>())
}

/// Any bits as a position; an integer takes the lower half of an `f64`'s bits.
trait AnyBits: Position {
    fn any(x: f64) -> Self;
}
impl AnyBits for f64 {
    fn any(x: f64) -> f64 {
        x
    }
}
impl AnyBits for Nanometres {
    fn any(x: f64) -> Nanometres {
        if (-1e4..1e4).contains(&x) { Nanometres::of(x) } else { Nanometres(x.to_bits() as i32) }
    }
}

fn check<R: Real, P: Position>(out: &Output<R, P, 3>, reference: Reference<R>) {
    let record = &out.record;
    for positions in [&out.drive, &out.feedback, &record.command, &record.feedback] {
        assert!(positions.iter().all(|p| p.to_f64().is_finite()), "{out:?}");
    }
    let mut numbers: Vec<R> = record.correction.to_vec();
    for contour in [&record.tip, &record.encoder] {
        numbers.extend(contour.vector.into());
        numbers.extend([contour.t, contour.error, contour.normal, contour.binormal, contour.tangential]);
        numbers.extend([contour.lag, contour.width]);
        let inside = contour.t >= R::ZERO && contour.t <= R::ONE;
        assert!(inside && contour.error >= R::ZERO, "{contour:?}");
        let on = reference.t >= R::ZERO && reference.t <= R::ONE;
        if contour.is_measured() {
            assert!(reference.t.is_finite());
            assert_eq!(contour.flags.has(Flags::REFERENCE), !on, "{reference:?} {contour:?}");
        }
    }
    numbers.push(record.orientation);
    assert!(numbers.iter().all(|x| x.is_finite()), "{out:?}");
    assert_eq!(record.status.has(Status::CONTOUR), record.tip.is_measured());
    let frame = Frame::of(record);
    for contour in [&frame.tip, &frame.encoder] {
        assert!([contour.error, contour.normal, contour.binormal, contour.lag].iter().all(|x| x.is_finite()));
    }
}

fn run<R: Real, P: AnyBits>(
    servo: &ServoLoop<'_, R, P, 3>,
    spans: &[Span<R, P>],
    cycles: &[Bits],
    commanded: Option<&mut CommandWindow<R, P, 16>>,
) {
    let path = Path::new(spans, 0, cycles.len().is_multiple_of(2));
    let mut state = servo.start();
    let mut bypass = Bypass::<P, 3>::new(Fault::TablesRefused);
    let mut commanded = commanded;
    let mut position = [12.0, 10.0, 10.0];
    for (command, feedback, t, span, elapsed_ns, bits) in cycles.iter().copied() {
        let bit = |n: u16| bits >> n & 1 == 1;
        let near = |x: f64| if x.is_finite() { x.rem_euclid(0.02) } else { 0.01 };
        let given = |k: usize, x: f64, raw: bool| if raw { P::any(x) } else { P::of(position[k] + near(x)) };
        let input = Input {
            command: [0, 1, 2].map(|k| given(k, command[k], bits & 7 == 7)),
            feedback: [0, 1, 2].map(|k| given(k, feedback[k], bits >> 3 & 3 == 3)),
            encoder_alarm: if bits >> 5 & 7 == 7 { (bits >> 8) as u8 } else { 0 },
            elapsed_ns,
            homed: bits >> 8 & 7 != 7,
            enable: bits >> 9 & 7 != 7,
            reset: bit(12),
            refusal: Refusal::NONE,
            ..Input::at_rest(elapsed_ns)
        };
        let reference = Reference { span, t: R::of(t) };
        let out = match &mut commanded {
            Some(commanded) => servo.step(&mut state, &input, &mut **commanded, ()),
            None => servo.step(&mut state, &input, path.on(reference), ()),
        };
        let expected = if commanded.is_some() { Reference { span: 0, t: R::ZERO } } else { reference };
        check(&out, expected);
        check(&bypass.step::<R>(&input), expected);
        let held = out.record.command.map(P::to_f64);
        if held.iter().all(|x| (0.0..100.0).contains(x)) {
            position = held;
        }
    }
}

type Built<R, P> = std::sync::LazyLock<&'static ServoLoop<'static, R, P, 3>>;
static DOUBLE: Built<f64, f64> = Built::new(|| servo_loop_with(1.0, |_| ()));
static MIXED: Built<f32, f64> = Built::new(|| servo_loop_with(1.0, |_| ()));
static SINGLE: Built<f32, Nanometres> = Built::new(|| servo_loop_with(1.0, |_| ()));

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(4_000) as u32, ..ProptestConfig::default() })]

    #[test]
    fn no_bits_make_a_number_that_is_none(cycles in prop::collection::vec(any_bits(), 1..60)) {
        run::<f64, f64>(&DOUBLE, &spans(), &cycles, None);
        run::<f32, f64>(&MIXED, &spans(), &cycles, None);
        run::<f32, Nanometres>(&SINGLE, &spans(), &cycles, None);
        let mut commanded = CommandWindow::new([0.0, 0.0, 1.0], 0.005).unwrap();
        run::<f64, f64>(&DOUBLE, &spans(), &cycles, Some(&mut commanded));
        let mut commanded = CommandWindow::new([0.0, 0.0, 1.0], 0.005).unwrap();
        run::<f32, Nanometres>(&SINGLE, &spans(), &cycles, Some(&mut commanded));
    }
}

/// The lag to a reference off its span is measured to the span's end, and flagged; a reference to no span gives no
/// contour error.
#[test]
fn a_reference_off_its_piece_is_taken_at_its_end_or_refused() {
    let servo = servo_loop(0.0);
    let spans = spans::<f64, f64>();
    let path = Path::new(&spans, 0, false);
    let length = spans[0].length();
    let warm = || {
        let mut state = servo.start();
        let at = input([10.0 + 0.5 * length, 10.0, 10.0]);
        for _ in 0..60 {
            servo.step(&mut state, &at, path.on(Reference { span: 0, t: 0.5 }), ());
        }
        let out = servo.step(&mut state, &at, path.on(Reference { span: 0, t: 0.5 }), ());
        assert!(out.record.status.has(Status::CONTOUR) && out.record.tip.lag.abs() < 1e-9);
        assert!(!out.record.tip.flags.has(Flags::COLD) && !out.record.tip.flags.has(Flags::REFERENCE));
        (state, at)
    };
    for (t, end) in [(1.0 + 1e-9, 1.0), (1.5, 1.0), (1e300, 1.0), (-1e-9, 0.0), (-7.0, 0.0), (f64::MIN, 0.0)] {
        let ((mut state, at), (mut other, _)) = (warm(), warm());
        let off = servo.step(&mut state, &at, path.on(Reference { span: 0, t }), ()).record;
        let on = servo.step(&mut other, &at, path.on(Reference { span: 0, t: end }), ()).record;
        assert!(off.status.has(Status::CONTOUR) && off.tip.flags.has(Flags::REFERENCE), "{t}: {off:?}");
        assert!(!on.tip.flags.has(Flags::REFERENCE));
        assert!((off.tip.lag - on.tip.lag).abs() < 1e-9 && (off.tip.error - on.tip.error).abs() < 1e-9, "{t}");
    }
    // −0 is the start.
    let (mut state, at) = warm();
    let out = servo.step(&mut state, &at, path.on(Reference { span: 0, t: -0.0 }), ()).record;
    assert!(out.status.has(Status::CONTOUR) && !out.tip.flags.has(Flags::REFERENCE));
    for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (mut state, at) = warm();
        let out = servo.step(&mut state, &at, path.on(Reference { span: 0, t }), ()).record;
        assert!(!out.status.has(Status::CONTOUR), "{t}");
        assert!(out.tip.flags.has(Flags::NOT_FOUND) && out.tip.flags.has(Flags::REFERENCE));
        assert_eq!((out.tip.lag, out.encoder.lag, out.tip.error), (0.0, 0.0, 0.0));
        // The search starts cold, as after any loss.
        let step = |_| servo.step(&mut state, &at, path.on(Reference { span: 0, t: 0.5 }), ()).record;
        let next: Vec<_> = (0..15).map(step).collect();
        assert!(next[0].tip.flags.has(Flags::SEARCHING) && !next[0].status.has(Status::CONTOUR));
        assert!(next[14].status.has(Status::CONTOUR) && next[14].tip.lag.is_finite());
    }
}
