//! Short legs that turn by almost 180°, with stops: order along the path decides that the foot is on the tip's leg.
//!
//! The tip follows the reference through a first-order servo, slower in one axis; the truth is the distance from all legs that
//! the reference has been on, and the largest lag that such a servo can have.

use super::*;
use crate::contour::ContourState;
use core::f64::consts::PI;

/// Number of paths of each kind at each rate.
const PATHS: usize = 10;

/// Construction of the legs.
#[derive(Clone, Copy, Debug)]
enum Legs {
    /// One line each.
    Lines,
    /// Lines joined by arcs of a few micrometres.
    Rounded,
    /// Several pieces each.
    Pieces,
}

/// Corners of legs of 0.05 to 1 mm that turn by 2.5 to 3.14 rad, in a plane of any direction.
fn corners(random: &mut Noise, legs: usize) -> Vec<V> {
    let (mut at, mut angle) = ([0.0; 3], random.range(-PI, PI));
    let tilt = random.range(-0.5, 0.5);
    let mut all = std::vec![at];
    for _ in 0..legs {
        let length = 10f64.powf(random.range(-1.3, 0.0));
        let (sin, cos) = angle.sin_cos();
        at = add(at, [length * cos, length * sin, length * tilt * cos]);
        all.push(at);
        angle += random.range(2.5, PI) * if random.unit() < 0.5 { 1.0 } else { -1.0 };
    }
    all
}

fn between(a: V, b: V, share: f64) -> V {
    add(a, sub(b, a).map(|x| x * share))
}

fn path(corners: &[V], legs: Legs) -> Vec<Span<f64, f64>> {
    let line = |a: V, b: V| Segment::Line { start: a.into(), end: b.into() };
    let mut segments = Vec::new();
    let mut from = corners[0];
    for (i, pair) in corners.windows(2).enumerate() {
        let [a, b] = [pair[0], pair[1]];
        let (mut to, mut arc) = (b, None);
        if let (Legs::Rounded, Some(c)) = (legs, corners.get(i + 2)) {
            // Cut off at 20 µm and rounded there.
            let [p, q] = [between(b, a, 0.02 / norm(sub(b, a))), between(b, *c, 0.02 / norm(sub(*c, b)))];
            let [u, v] = [sub(a, b), sub(*c, b)].map(DVec3::from_array);
            let (u, v) = (u.normalize(), v.normalize());
            let half = 0.5 * u.angle_between(v);
            let center = DVec3::from_array(b) + (u + v).normalize() * (0.02 / half.cos());
            let normal = v.cross(u).normalize();
            (to, arc) = (p, Some((Segment::Arc { start: p.into(), end: q.into(), center, normal, turns: 0 }, q)));
        }
        let pieces = if let Legs::Pieces = legs { (norm(sub(to, from)) / 0.04).ceil() as usize } else { 1 };
        let cut = |k: usize| between(from, to, k as f64 / pieces as f64);
        segments.extend((0..pieces).map(|k| line(cut(k), cut(k + 1))));
        from = to;
        if let Some((arc, q)) = arc {
            segments.push(arc);
            from = q;
        }
    }
    spans(&segments)
}

/// Motion from rest to rest over a length: positions one period apart.
fn strokes(length: f64, feed: f64, acceleration: f64, period: f64) -> Vec<f64> {
    let feed = feed.min((acceleration * length).sqrt());
    let (ramp, total) = (feed / acceleration, length / feed + feed / acceleration);
    let place = |t: f64| {
        let t = t.clamp(0.0, total);
        let rest = total - t;
        if t < ramp {
            0.5 * acceleration * t * t
        } else if rest < ramp {
            length - 0.5 * acceleration * rest * rest
        } else {
            feed * (t - 0.5 * ramp)
        }
    };
    (1..=(total / period).ceil() as usize).map(|k| place(k as f64 * period)).collect()
}

/// Distance from a leg.
fn from_leg(p: V, a: V, b: V) -> f64 {
    let [d, r] = [sub(b, a), sub(p, a)];
    norm(sub(r, d.map(|x| x * (dot(&r, &d) / dot(&d, &d)).clamp(0.0, 1.0))))
}

/// Distance from the part of a path between two arc lengths from its start.
fn from_part(all: &[Span<f64, f64>], p: V, [begin, end]: [f64; 2]) -> f64 {
    let (mut start, mut least) = (0.0, f64::MAX);
    for span in all {
        let length = span.length();
        let [from, to] = [begin, end].map(|s| ((s - start) / length).clamp(0.0, 1.0));
        if from < to {
            // Lines, and arcs of a hundredth of a millimetre: 20 nm off.
            let chords = if span.form == crate::contour::Form::Cubic { 1 } else { 4 };
            let at = |k: u8| span.position(from + (to - from) * f64::from(k) / f64::from(chords));
            least = (0..chords).map(|k| from_leg(p, at(k), at(k + 1))).fold(least, f64::min);
        }
        start += length;
    }
    least
}

/// Counts cycles in which a foot was wrong and not flagged: by its distance, by its lag; flagged ones, the total, and cold
/// ones.
fn follow(random: &mut Noise, legs: Legs, rate: f64) -> [u32; 5] {
    let (gain, slower) = (random.range(60.0, 150.0), random.range(0.7, 1.0));
    let (feed, acceleration) = (10f64.powf(random.range(0.0, 1.3)), random.range(300.0, 3000.0));
    let all = path(&corners(random, 4), legs);
    let total: f64 = all.iter().map(Span::length).sum();
    let mut places = std::vec![0.0; 80];
    // A path's legs end where it turns.
    let mut end = 0.0;
    let mut begin = 0.0;
    for (i, span) in all.iter().enumerate() {
        end += span.length();
        let turns = all.get(i + 1).is_none_or(|next| {
            let [a, b] = [span, next].map(|span| sub(span.position(1.0), span.position(0.0)));
            dot(&a, &b) < 0.9 * norm(a) * norm(b)
        });
        if turns {
            places.extend(strokes(end - begin, feed, acceleration, 1.0 / rate).iter().map(|s| begin + s));
            begin = end;
        }
    }
    let most_lag = 1.1 * feed / (gain * slower) + 0.01;
    let mut walk = Walk::new(&all, false);
    let mut alone = ContourState::default();
    let mut tip = all[0].position(0.0);
    let mut counts = [0; 5];
    let cycle = [gain, gain * slower, gain].map(|gain| 1.0 - (-gain / rate).exp());
    for (i, s) in places.iter().enumerate() {
        let reference = place(&all, s.min(total));
        let at = all[reference.span as usize].position(reference.t);
        tip = core::array::from_fn(|k| tip[k] + cycle[k] * (at[k] - tip[k]));
        let [found, _] = walk.step(reference, tip, add(tip, [4e-4, -3e-4, 0.0]));
        let single = walk.search.update(&mut alone, &walk.path, reference, tip);
        if i < 80 {
            continue;
        }
        let truth = from_part(&all, tip, [s - most_lag, s + 0.01]);
        for found in [found, single] {
            let cold = found.flags.has(Flags::COLD);
            let said = cold || found.flags.has(Flags::SECOND_MINIMUM) || !found.flags.has(Flags::BRACKETED);
            counts[0] += u32::from(!said && (found.error - truth).abs() > 1e-3);
            counts[1] += u32::from(!said && !(-0.02..2.0 * most_lag).contains(&found.lag));
            counts[2] += u32::from(said);
            counts[4] += u32::from(cold);
            counts[3] += 1;
        }
    }
    counts
}

#[test]
fn the_foot_stays_on_the_leg_that_the_reference_is_on_or_has_just_left() {
    let mut random = Noise::new(17);
    let mut wrong = Vec::new();
    for legs in [Legs::Lines, Legs::Rounded, Legs::Pieces] {
        let mut sum = [0; 5];
        for rate in [1e3, 2e3, 4e3, 8e3] {
            for _ in 0..PATHS {
                let counts = follow(&mut random, legs, rate);
                sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
        }
        let [off, behind, said, cycles, cold] = sum;
        // If the contour error is tens of micrometres, a third leg may be nearer, and a rounding of a few micrometres has
        // additional minima; at 1 kHz a cycle may cover more spans than the search permits, so the search starts cold.
        if off * 1000 > cycles || behind * 10_000 > cycles || said * 3 > cycles || cold * 50 > cycles {
            wrong.push((legs, sum));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
