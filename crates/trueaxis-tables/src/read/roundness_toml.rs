//! `[roundness]` of `machine.toml`: a gauge of three probes.

use super::section::{Found, Section};
use crate::error::FileError;
use trueaxis::machine::Axis;
use trueaxis::roundness::{
    Arm, ArmSettings, Band, GaugeSettings, INFEED_NOISE_GAIN_LIMIT, InfeedSettings, ProbeAngles, ProbeSettings,
    SpindleEncoder,
};

const COUNTS: &str = "a whole number of counts per revolution";

/// The section; `None` where the file has none.
pub(super) fn read(root: &Section<'_>) -> Result<Option<GaugeSettings>, FileError> {
    let Some(section) = root.section("roundness")? else { return Ok(None) };
    let points = section
        .whole("points", "a power of two from 64 to 4096")?
        .ok_or_else(|| section.missing("points", "the points of a revolution, 64 to 4096"))?;
    let counts = section
        .whole("spindle_counts_per_revolution", COUNTS)?
        .ok_or_else(|| section.missing("spindle_counts_per_revolution", "the counts of the spindle's encoder"))?;
    let (angles, angles_at) = read_angles(&section)?;
    let mut settings = GaugeSettings::with_defaults(points, angles, counts);
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

/// A whole number that fits into 16 bits.
fn short(value: f64) -> Option<u16> {
    (value.fract() == 0.0 && (0.0..=65_535.0).contains(&value)).then_some(value as u16)
}

fn read_angles(section: &Section<'_>) -> Result<(ProbeAngles, Found<[f64; 2]>), FileError> {
    match (section.numbers::<2>("probe_slots")?, section.numbers::<2>("probe_angles_deg")?) {
        (Some(found), None) => {
            let [Some(p), Some(q)] = found.value.map(short) else {
                return Err(section.wrong(&found, "two whole numbers, p and q"));
            };
            Ok((ProbeAngles::Slots { p, q }, found))
        }
        (None, Some(found)) => {
            let [phi2, phi3] = found.value;
            Ok((ProbeAngles::Degrees { phi2, phi3 }, found))
        }
        (Some(_), Some(found)) => Err(section.wrong(&found, "either probe_slots or probe_angles_deg")),
        (None, None) => Err(section.missing("probe_slots", "probe_slots = [p, q] or probe_angles_deg")),
    }
}

fn read_band(section: &Section<'_>, to: &mut Band) -> Result<(), FileError> {
    let Some(found) = section.numbers::<2>("harmonics")? else { return Ok(()) };
    let [Some(first), Some(last)] = found.value.map(short) else {
        return Err(section.wrong(&found, "two whole numbers, lowest and highest harmonic"));
    };
    *to = Band { first, last };
    Ok(())
}

fn read_keys(section: &Section<'_>, settings: &mut GaugeSettings) -> Result<(), FileError> {
    read_band(section, &mut settings.band)?;
    section.set("noise_gain_limit", &mut settings.noise_gain_limit, |limit| limit)?;
    let SpindleEncoder { direction, index, index_tolerance, .. } = &mut settings.spindle;
    section.set_direction("spindle_direction", direction)?;
    if let Some(given) = section.boolean("spindle_index")? {
        *index = given;
    }
    section.set_whole("spindle_index_tolerance_counts", index_tolerance, "a whole number of counts")?;
    section.set("stop_s", &mut settings.stop_s, |s| s)?;
    section.set_whole("revolutions", &mut settings.revolutions, "a whole number from 1 to 10,000")?;
    section.set_whole("units_per_cycle", &mut settings.slices_per_cycle, "a whole number from 1 to 16")?;
    settings.filter = section.whole("filter_upr", "a cut-off of 15, 50, 150 or 500 UPR")?;
    read_probes(section, &mut settings.probes)
}

fn read_probes(section: &Section<'_>, probes: &mut [ProbeSettings; 3]) -> Result<(), FileError> {
    let mut gains = probes.map(|probe| probe.gain_um);
    section.set_all("probe_gain_um", &mut gains)?;
    let mut zeros = probes.map(|probe| probe.zero);
    section.set_all("probe_zero", &mut zeros)?;
    let mut low = probes.map(|probe| probe.range[0]);
    section.set_all("probe_low", &mut low)?;
    let mut high = probes.map(|probe| probe.range[1]);
    section.set_all("probe_high", &mut high)?;
    for (i, probe) in probes.iter_mut().enumerate() {
        *probe = ProbeSettings { gain_um: gains[i], zero: zeros[i], range: [low[i], high[i]] };
    }
    Ok(())
}

fn read_arm(section: &Section<'_>) -> Result<ArmSettings, FileError> {
    let length = |key| {
        let found = section.number(key)?.ok_or_else(|| section.missing(key, "a length of the linkage"))?;
        Ok::<_, FileError>(found.value)
    };
    let lengths = Arm { crank_mm: length("crank_mm")?, wheel_mm: length("wheel_mm")?, pin_mm: length("pin_mm")? };
    let counts = section
        .whole("counts_per_revolution", COUNTS)?
        .ok_or_else(|| section.missing("counts_per_revolution", "the counts of the arm's encoder in a full turn"))?;
    let mut arm = ArmSettings { lengths, counts, direction: 1, tolerance_deg: 1.0 };
    section.set_direction("direction", &mut arm.direction)?;
    section.set("tolerance_deg", &mut arm.tolerance_deg, |degrees| degrees)?;
    Ok(arm)
}

fn read_infeed(section: &Section<'_>, settings: &GaugeSettings) -> Result<InfeedSettings, FileError> {
    let axis = section.string("axis")?.ok_or_else(|| section.missing("axis", "the axis that feeds in, like \"X\""))?;
    let letter = axis.value.chars().next().filter(|_| axis.value.len() == 1);
    let Some(letter) = letter.and_then(Axis::from_letter) else {
        return Err(section.wrong(&axis, "an axis, X, Y or Z"));
    };
    let mut infeed = InfeedSettings {
        axis: letter,
        direction: 1,
        band: Band { first: settings.band.first, last: settings.band.last.min(settings.points / 8) },
        gain: 0.25,
        delay_revolutions: 2,
        contact_deg: 180.0,
        drive_delay_s: 0.0,
        limit_um: 20.0,
        noise_gain_limit: INFEED_NOISE_GAIN_LIMIT,
    };
    section.set_direction("direction", &mut infeed.direction)?;
    section.set("gain", &mut infeed.gain, |gain| gain)?;
    section.set_whole("delay_revolutions", &mut infeed.delay_revolutions, "a whole number from 1 to 16")?;
    section.set("contact_deg", &mut infeed.contact_deg, |degrees| degrees)?;
    section.set("drive_delay_s", &mut infeed.drive_delay_s, |s| s)?;
    section.set("limit_um", &mut infeed.limit_um, |um| um)?;
    section.set("noise_gain_limit", &mut infeed.noise_gain_limit, |limit| limit)?;
    read_band(section, &mut infeed.band)?;
    Ok(infeed)
}
