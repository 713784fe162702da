//! `[roundness]` of `machine.toml`: a three-probe gauge.

use super::section::{KeyValue, Section};
use crate::error::FileError;
use trueaxis::machine::Axis;
use trueaxis::roundness::{
    Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles, ProbeSettings, SpindleEncoder,
};

/// A number that has to be whole and in the range of its type.
fn whole<T: TryFrom<i64>>(section: &Section<'_>, found: &KeyValue<f64>, needed: &str) -> Result<T, FileError> {
    let value = found.value;
    let whole = (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64);
    whole.and_then(|value| T::try_from(value).ok()).ok_or_else(|| section.wrong(found, needed))
}

/// Readers of optional keys.
impl Section<'_> {
    fn store_whole<T: TryFrom<i64>>(&self, to: &mut T, key: &str, needed: &str) -> Result<(), FileError> {
        if let Some(found) = self.number(key)? {
            *to = whole(self, &found, needed)?;
        }
        Ok(())
    }

    fn store_band(&self, to: &mut Band, key: &str) -> Result<(), FileError> {
        let Some(found) = self.numbers::<2>(key)? else { return Ok(()) };
        let harmonic = |value: f64| (value.fract() == 0.0 && (0.0..=65_535.0).contains(&value)).then_some(value as u16);
        let [first, last] = found.value.map(harmonic);
        let (Some(first), Some(last)) = (first, last) else {
            return Err(self.wrong(&found, "two whole numbers, lowest and highest harmonic"));
        };
        *to = Band { first, last };
        Ok(())
    }

    fn store_direction(&self, to: &mut i8, key: &str) -> Result<(), FileError> {
        let Some(found) = self.number(key)? else { return Ok(()) };
        *to = match found.value {
            1.0 => 1,
            -1.0 => -1,
            _ => return Err(self.wrong(&found, "1 or -1")),
        };
        Ok(())
    }
}

const COUNTS: &str = "a whole number of counts per revolution";

/// The section; `None` if the file has none.
pub(super) fn read(root: &Section<'_>) -> Result<Option<GaugeSettings>, FileError> {
    let Some(section) = root.section("roundness")? else { return Ok(None) };
    let points =
        section.number("points")?.ok_or_else(|| section.missing("points", "the points of a revolution, 64 to 4096"))?;
    let counts = section
        .number("spindle_counts_per_revolution")?
        .ok_or_else(|| section.missing("spindle_counts_per_revolution", "the counts of the spindle's encoder"))?;
    let (slots, degrees) = (section.numbers::<2>("probe_slots")?, section.numbers::<2>("probe_angles_deg")?);
    let (angles, angles_at) = match (slots, degrees) {
        (Some(found), None) => {
            let slot = |value: f64| (value.fract() == 0.0 && (0.0..=65_535.0).contains(&value)).then_some(value as u16);
            let [Some(p), Some(q)] = found.value.map(slot) else {
                return Err(section.wrong(&found, "two whole numbers, p and q"));
            };
            (ProbeAngles::Slots { p, q }, found)
        }
        (None, Some(found)) => {
            let [phi2, phi3] = found.value;
            (ProbeAngles::Degrees { phi2, phi3 }, found)
        }
        (Some(_), Some(found)) => return Err(section.wrong(&found, "either probe_slots or probe_angles_deg")),
        (None, None) => return Err(section.missing("probe_slots", "probe_slots = [p, q] or probe_angles_deg")),
    };
    let mut settings = GaugeSettings::with_defaults(
        whole(&section, &points, "a power of two from 64 to 4096")?,
        angles,
        whole(&section, &counts, COUNTS)?,
    );
    read_keys(&section, &mut settings)?;
    if let Some(arm) = section.section("arm")? {
        settings.arm = Some(read_arm(&arm)?);
        arm.finish(None)?;
    }
    if let Some(infeed) = section.section("infeed")? {
        settings.infeed = Some(read_infeed(&infeed, &settings)?);
        infeed.finish(None)?;
    }
    let points = usize::from(settings.points);
    if let (Ok(()), Ok(gain)) = (settings.band.check(points), settings.angles.resolve(points)) {
        let blind: Vec<String> = gain.singular(settings.band).map(|k| k.to_string()).collect();
        if !blind.is_empty() {
            let needed = format!(
                "angles that see every harmonic of the band (trueaxis probe-angles finds some); these do not see {}",
                blind.join(", ")
            );
            return Err(section.wrong(&angles_at, needed));
        }
    }
    section.finish(None)?;
    Ok(Some(settings))
}

fn read_keys(section: &Section<'_>, settings: &mut GaugeSettings) -> Result<(), FileError> {
    section.store_band(&mut settings.band, "harmonics")?;
    section.store(&mut settings.noise_gain_limit, "noise_gain_limit", |limit| limit)?;
    let SpindleEncoder { direction, index, index_tolerance, .. } = &mut settings.spindle;
    section.store_direction(direction, "spindle_direction")?;
    if let Some(given) = section.boolean("spindle_index")? {
        *index = given;
    }
    section.store_whole(index_tolerance, "spindle_index_tolerance_counts", "a whole number of counts")?;
    section.store(&mut settings.stop_s, "stop_s", |seconds| seconds)?;
    section.store_whole(&mut settings.revolutions, "revolutions", "a whole number from 1 to 10,000")?;
    section.store_whole(&mut settings.slices_per_cycle, "units_per_cycle", "a whole number from 1 to 16")?;
    let mut cut_off = 0;
    section.store_whole(&mut cut_off, "filter_upr", "a cut-off of 15, 50, 150 or 500 UPR")?;
    settings.filter = section.number("filter_upr")?.map(|_| cut_off);
    read_probes(section, &mut settings.probes)
}

fn read_probes(section: &Section<'_>, probes: &mut [ProbeSettings; 3]) -> Result<(), FileError> {
    let mut gains = probes.map(|probe| probe.gain_um);
    section.store_all(&mut gains, "probe_gain_um")?;
    let mut zeros = probes.map(|probe| probe.zero);
    section.store_all(&mut zeros, "probe_zero")?;
    let mut low = probes.map(|probe| probe.range[0]);
    section.store_all(&mut low, "probe_low")?;
    let mut high = probes.map(|probe| probe.range[1]);
    section.store_all(&mut high, "probe_high")?;
    for (i, probe) in probes.iter_mut().enumerate() {
        *probe = ProbeSettings { gain_um: gains[i], zero: zeros[i], range: [low[i], high[i]] };
    }
    Ok(())
}

fn read_arm(section: &Section<'_>) -> Result<ArmSettings, FileError> {
    let mut arm = ArmSettings {
        lengths: Arm { crank_mm: 0.0, wheel_mm: 0.0, pin_mm: 0.0 },
        counts: 0,
        direction: 1,
        tolerance_deg: 1.0,
    };
    let lengths = &mut arm.lengths;
    for (key, to) in
        [("crank_mm", &mut lengths.crank_mm), ("wheel_mm", &mut lengths.wheel_mm), ("pin_mm", &mut lengths.pin_mm)]
    {
        *to = section.number(key)?.ok_or_else(|| section.missing(key, "a length of the linkage"))?.value;
    }
    let counts = section
        .number("counts_per_revolution")?
        .ok_or_else(|| section.missing("counts_per_revolution", "the counts of the arm's encoder in a full turn"))?;
    arm.counts = whole(section, &counts, COUNTS)?;
    section.store_direction(&mut arm.direction, "direction")?;
    section.store(&mut arm.tolerance_deg, "tolerance_deg", |degrees| degrees)?;
    Ok(arm)
}

fn read_infeed(section: &Section<'_>, settings: &GaugeSettings) -> Result<InfeedSettings, FileError> {
    let axis = section.string("axis")?.ok_or_else(|| section.missing("axis", "the axis that feeds in, like \"X\""))?;
    let letter = axis.value.chars().next().filter(|_| axis.value.len() == 1);
    let Some(letter) = letter.and_then(Axis::from_letter) else {
        return Err(section.wrong(&axis, "an axis, X, Y or Z"));
    };
    let band = Band { first: settings.band.first, last: settings.band.last.min(settings.points / 8) };
    let mut infeed = InfeedSettings::with_defaults(letter, band);
    section.store_direction(&mut infeed.direction, "direction")?;
    section.store(&mut infeed.gain, "gain", |gain| gain)?;
    section.store_whole(&mut infeed.delay_revolutions, "delay_revolutions", "a whole number from 1 to 16")?;
    section.store(&mut infeed.contact_deg, "contact_deg", |degrees| degrees)?;
    section.store(&mut infeed.drive_delay_s, "drive_delay_s", |seconds| seconds)?;
    section.store(&mut infeed.limit_um, "limit_um", |um| um)?;
    section.store(&mut infeed.noise_gain_limit, "noise_gain_limit", |limit| limit)?;
    section.store_band(&mut infeed.band, "harmonics")?;
    Ok(infeed)
}
