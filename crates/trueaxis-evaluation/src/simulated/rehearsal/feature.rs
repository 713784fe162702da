//! Records of probing tests: a ring, a sphere or a point under the machine's own probe.

use super::instrument::{Instrument, NOISE_UM, middle};
use crate::probing::Feature;
use crate::range::OutOfRange;
use anyhow::{Context, Result, bail};
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis_sim::calibration::{Artefact, Drift, Host, Probing, execute};

/// Standard deviation of the feature's place, mm.
const MISPLACED_MM: f64 = 0.1;
/// Way before and after the surface, mm.
const WAY_MM: f64 = 3.0;
/// Height above a sphere at which the probe moves over it, mm.
const CLEAR_MM: f64 = 10.0;

/// Touches of one feature.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbedFeature {
    /// The feature.
    pub feature: Feature,
    /// Diameter of ring or sphere, mm.
    pub diameter_mm: f64,
    /// Diameter of the stylus tip, mm.
    pub tip_mm: f64,
    /// Amplitude of the probe's lobes around the tip, three of them, mm.
    pub lobes_mm: f64,
    /// Axis positions of its centre, mm; `None`: the middle of the travels.
    pub at_mm: Option<[f64; 3]>,
    /// Runs, 1 to 100.
    pub runs: u32,
}

impl ProbedFeature {
    /// Checks diameters and lobes.
    ///
    /// # Errors
    /// A figure out of its range, a tip that does not go into the ring.
    pub fn check(&self) -> Result<(), OutOfRange> {
        OutOfRange::check("diameter_mm", self.diameter_mm, 1.0..=1000.0, "mm")?;
        let most = if self.feature == Feature::Ring { 0.5 * self.diameter_mm } else { 50.0 };
        OutOfRange::check("tip_mm", self.tip_mm, 0.1..=most, "mm")?;
        OutOfRange::check("lobes_um", 1e3 * self.lobes_mm, 0.0..=100.0, "um")
    }

    /// The record in the format that `trueaxis evaluate probing` reads: 36 points on a ring, 25 over half a sphere, 10
    /// touches of a point.
    ///
    /// # Errors
    /// A feature outside the travel, a machine so wrong that it misses it.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        let mut draws = of.conditions.set_up_draws();
        let off = DVec3::from_array([0; 3].map(|_| MISPLACED_MM * draws.normal().clamp(-2.0, 2.0)));
        let centre = self.centre(of)?;
        let mut text = String::from("x_mm,y_mm,z_mm,run\n");
        for run in 1..=self.runs {
            let probing = Probing {
                machine: of.truth.clone(),
                known: of.known.cloned(),
                set_ups: vec![vec![self.artefact(of, centre, off)?]],
                tools_mm: Vec::new(),
                tip_radius_mm: 0.5 * self.tip_mm,
                pre_travel_mm: 0.0,
                lobes_mm: self.lobes_mm,
                noise_mm: 1e-3 * of.conditions.noise_um.unwrap_or(NOISE_UM),
                drift: Drift { rate: of.conditions.rate(), ..Drift::default() },
                pause_s: 60.0 * f64::from(run),
                seed: of.conditions.seed.wrapping_mul(1_000).wrapping_add(u64::from(run)),
                host: Host::LinuxCnc,
            };
            let log = execute(&probing, &self.program(centre)).context("the touches of the feature")?;
            for touch in log.lines() {
                let _ = writeln!(text, "{},{run}", touch.replace(' ', ","));
            }
        }
        Ok(text)
    }

    fn centre(&self, of: &Instrument<'_>) -> Result<DVec3> {
        let reach = 0.5 * self.diameter_mm + self.tip_mm + CLEAR_MM + WAY_MM;
        let mut centre = DVec3::ZERO;
        for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            let letter = axis.letter();
            let Some(own) = of.truth.settings.axis(axis) else { bail!("found a machine without {letter}, needed it") };
            centre[k] = self.at_mm.map_or_else(|| middle(own, "--at-mm X,Y,Z"), |at| Ok(at[k]))?;
            let [low, high] = own.travel;
            if centre[k] - reach < low || centre[k] + reach > high {
                bail!("found the feature at {letter} {}, needed it {reach} mm within {low} to {high} mm", centre[k]);
            }
        }
        Ok(centre)
    }

    fn artefact(&self, of: &Instrument<'_>, centre: DVec3, off: DVec3) -> Result<Artefact> {
        let ideal = crate::calibrate::Ideal::new(of.truth)?;
        let DVec3 { x, y, z } = centre + off;
        let at = DVec3::from(ideal.tip(&[x, y, z, 0.0, 0.0, 0.0]));
        let diameter = self.diameter_mm;
        Ok(match self.feature {
            Feature::Ring => Artefact::Ring { centre: at, axis: DVec3::Z, diameter },
            Feature::Sphere => Artefact::Ball { centre: at, diameter },
            Feature::Point => {
                let half = DVec3::splat(0.5 * diameter);
                Artefact::Block { centre: at, directions: DMat3::IDENTITY, half }
            }
        })
    }

    /// G-code of one run; the leading M0 sets the feature up.
    fn program(&self, centre: DVec3) -> String {
        let mut text = String::from("G17 G21 G90 G94\n");
        let mut set_up = Some("M0\n");
        let start = 0.5 * (self.diameter_mm + self.tip_mm) + WAY_MM;
        let above = centre.z + start + CLEAR_MM;
        for way in self.ways() {
            let (from, to) = match self.feature {
                Feature::Ring => (centre, centre + (0.5 * (self.diameter_mm - self.tip_mm) + WAY_MM) * way),
                _ => (centre + start * way, centre + (start - 2.0 * WAY_MM) * way),
            };
            if self.feature != Feature::Ring {
                let _ = writeln!(text, "G0 Z{above:.6}\nG0 X{:.6} Y{:.6}", from.x, from.y);
            }
            let _ = writeln!(text, "G0 X{:.6} Y{:.6} Z{:.6}", from.x, from.y, from.z);
            text.push_str(set_up.take().unwrap_or_default());
            let _ = writeln!(text, "G38.2 X{:.6} Y{:.6} Z{:.6} F60\n(LOG,#5061 #5062 #5063)", to.x, to.y, to.z);
            let _ = writeln!(text, "G1 X{:.6} Y{:.6} Z{:.6} F1000", from.x, from.y, from.z);
        }
        text + "M2\n"
    }

    /// Directions of the touches, outwards from the feature's centre.
    fn ways(&self) -> Vec<DVec3> {
        let around = |height: f64, count: u32, phase: f64| {
            (0..count).map(move |k| {
                let angle = TAU * (f64::from(k) + phase) / f64::from(count);
                DVec3::new(height.cos() * angle.cos(), height.cos() * angle.sin(), height.sin())
            })
        };
        match self.feature {
            Feature::Ring => around(0.0, 36, 0.0).collect(),
            // A pole and three rows of eight.
            Feature::Sphere => {
                let rows = [0.0, 1.0, 2.0].map(|row| around(row * PI / 6.0, 8, 0.5 * (row % 2.0)));
                std::iter::once(DVec3::Z).chain(rows.into_iter().flatten()).collect()
            }
            Feature::Point => vec![DVec3::Z; 10],
        }
    }
}
