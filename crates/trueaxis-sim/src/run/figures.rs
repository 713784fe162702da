//! Figures of the machines of a run side by side, as a document.

use super::kind::Kind;
use super::tally::{AngleSize, ErrorSize, Tallies};
use crate::scenario::Scenario;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use trueaxis::Axis;

/// Largest and root mean square.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Largest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

impl From<ErrorSize> for Size {
    fn from(size: ErrorSize) -> Size {
        Size { max: size.max_um, rms: size.rms_um }
    }
}

impl From<AngleSize> for Size {
    fn from(size: AngleSize) -> Size {
        Size { max: size.max_urad, rms: size.rms_urad }
    }
}

/// A value for every machine; in JSON an object keyed by [`Kind::name`].
#[derive(Clone, Debug, PartialEq)]
pub struct ByKind<T>(pub Vec<(Kind, T)>);

impl<T: Serialize> Serialize for ByKind<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (kind, value) in &self.0 {
            map.serialize_entry(kind.name(), value)?;
        }
        map.end()
    }
}

/// A fault that a machine reported over consecutive cycles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedFault {
    /// Time, s from the start of the program.
    pub time_s: f64,
    /// Name of the fault.
    pub fault: String,
    /// Code of the fault.
    pub code: u8,
    /// Faulty axis.
    pub axis: char,
    /// Program line.
    pub line: u32,
    /// Number of cycles.
    pub cycles: u64,
}

/// Factors in use on the identified friction of an axis that adapts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrictionFactors {
    /// Factor of the Coulomb friction.
    pub coulomb: f64,
    /// Factor of the pre-sliding.
    pub presliding: f64,
}

/// Figures of a run so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// True contour error of the tool tip while cutting, µm.
    pub contour_error_um: ByKind<Size>,
    /// True angle between the tool and the programmed direction, µrad; programs with rotary axes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_error_urad: Option<ByKind<Size>>,
    /// Contour error as the step itself reports it, µm; programs with rotary axes only. Omitted for the perfect machine, for
    /// which the step would report errors that its tables have and that machine does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_contour_error_um: Option<ByKind<Size>>,
    /// Orientation error as the step reports it, µrad; also without the perfect machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_orientation_error_urad: Option<ByKind<Size>>,
    /// Faults of the compensated machine or, in a run without it, of the first machine whose plugin is enabled.
    pub faults: Vec<ReportedFault>,
    /// Whether that machine was stopped by a stop request.
    pub stopped: bool,
    /// Cycles of that machine in which an axis' correction was limited.
    pub limited_cycles: u64,
    /// Factors of the axes whose friction adapts, in the last cycle; machines that compensate friction only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_factors: Option<ByKind<BTreeMap<char, FrictionFactors>>>,
    /// Digest of all outputs of the step while the program ran, without settling: two runs with equal digests gave equal bits,
    /// except with a probability of one in 2³². Eight hexadecimal digits.
    pub digest: ByKind<String>,
}

impl Figures {
    /// Collects the figures of the machines of a run of `scenario` from their tallies.
    pub fn of(scenario: &Scenario, machines: &[(Kind, Tallies)]) -> Figures {
        let sizes = |size: &dyn Fn(&Tallies) -> Size| ByKind(machines.iter().map(|(k, t)| (*k, size(t))).collect());
        let estimates = |size: &dyn Fn(&Tallies) -> Size| {
            let imperfect = machines.iter().filter(|(kind, _)| *kind != Kind::ServoOnly);
            scenario.five_axis.then(|| ByKind(imperfect.map(|(k, t)| (*k, size(t))).collect()))
        };
        let driven = machines.iter().filter(|(kind, _)| kind.enables_the_plugin());
        let chief = driven.min_by_key(|(kind, _)| *kind != Kind::Compensated).map(|(_, tallies)| tallies);
        let factors = |(kind, tallies): &(Kind, Tallies)| {
            let all = tallies.friction_factors();
            (!all.is_empty()).then_some((*kind, all))
        };
        Figures {
            contour_error_um: sizes(&|t| t.error.into()),
            orientation_error_urad: scenario.five_axis.then(|| sizes(&|t| t.orientation.into())),
            estimated_contour_error_um: estimates(&|t| t.estimated.into()),
            estimated_orientation_error_urad: estimates(&|t| t.estimated_orientation.into()),
            faults: chief.map(|tallies| tallies.reported_faults(scenario).collect()).unwrap_or_default(),
            stopped: chief.is_some_and(|tallies| tallies.stopped),
            limited_cycles: chief.map_or(0, |tallies| tallies.limited_cycles),
            friction_factors: Some(ByKind(machines.iter().filter_map(factors).collect()))
                .filter(|all| !all.0.is_empty()),
            digest: ByKind(machines.iter().map(|(k, t)| (*k, format!("{:08x}", t.digest))).collect()),
        }
    }
}

impl Tallies {
    /// Factors of the axes whose friction adapts, in the last cycle.
    fn friction_factors(&self) -> BTreeMap<char, FrictionFactors> {
        let adapting = Axis::ALL.into_iter().zip(self.friction).filter(|(_, factors)| *factors != [0.0; 2]);
        let factors = |[coulomb, presliding]: [f32; 2]| FrictionFactors {
            coulomb: coulomb.into(),
            presliding: presliding.into(),
        };
        adapting.map(|(axis, own)| (axis.letter(), factors(own))).collect()
    }

    /// The faults with their times.
    pub fn reported_faults<'t>(&'t self, scenario: &'t Scenario) -> impl Iterator<Item = ReportedFault> + 't {
        self.faults.iter().map(|span| ReportedFault {
            time_s: span.cycle as f64 * scenario.period_s(),
            fault: format!("{:?}", span.fault),
            code: span.fault as u8,
            axis: span.axis.letter(),
            line: span.line,
            cycles: span.cycles,
        })
    }
}
