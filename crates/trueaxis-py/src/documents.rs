//! Roundness: circles, one trace, three probes and their angles.

use crate::json::dictionary;
use crate::shown::{result, table_result};
use crate::{arrays, to_python, units, warn};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::path::Path;
use trueaxis_evaluation::probes::Probes;
use trueaxis_evaluation::{circle as circles, probe_angles as angles, roundness as separation};
use trueaxis_metrology::separation::NOISE_GAIN_LIMIT;

/// Fit the reference circles of ISO 12181-1 to points of a section.
///
/// Parameters
/// ----------
/// points : array-like or data frame
///     (n, 2), mm, or a data frame with the columns x_mm, y_mm.
///
/// Returns
/// -------
/// Circle
///     The document of `trueaxis circle --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Examples
/// --------
/// >>> found = trueaxis.circle([[1, 0], [0, 1], [-1, 0], [0, -1.002]])
/// >>> round(found.mcc.radius_mm, 6), round(found.mzc.zone_um, 6)
/// (1.001, 0.9995)
#[pyfunction]
pub(crate) fn circle<'py>(py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let forms: &[&[&str]] = &[&["x_mm", "y_mm"]];
    let (_, values) = arrays::named(&units::framed(points, "points", forms)?, "points", forms)?;
    let found = to_python(py.detach(|| {
        let points = values.as_chunks::<2>().0.to_vec();
        let lines = (0..points.len() as u32).collect();
        circles::Evaluation::of(points, lines, Path::new("points"))
    }))?;
    result("Circle", dictionary(py, &found.document())?, Some(found.shown()))
}

/// Fit the reference circles of ISO 12181-1 to one trace of radii, with or without a filter.
///
/// Parameters
/// ----------
/// radius_mm : array-like
///     Radii over one revolution, mm, of any number; with theta_deg, at these angles.
/// theta_deg : array-like, optional
///     Increasing angles of the radii, degrees; by default, equidistant ones from 0.
/// upr : int, optional
///     Cut-off of the Gaussian filter in undulations per revolution: 15, 50, 150 or 500; by default, no filter. With a
///     filter, radii at given angles are first resampled to equidistant ones.
///
/// Returns
/// -------
/// Circle
///     The circles, as `circle` finds them, with the arrays theta_deg and radius_mm, the trace as filtered.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// The filter is that of ISO 16610-21 for a closed profile, H(k) = 2^−(k/k_c)²; it attenuates eccentricity like any other
/// harmonic. ISO 12181-2 asks for seven points for each undulation at the cut-off; fewer raise a warning.
///
/// Examples
/// --------
/// >>> theta = np.arange(0, 360, 0.25)
/// >>> lobes = 25 + 0.002 * np.cos(np.radians(3 * theta)) + 0.001 * np.cos(np.radians(50 * theta))
/// >>> found = trueaxis.trace_roundness(lobes, upr=50)
/// >>> round(found.lsc.zone_um, 2)
/// 4.99
#[pyfunction]
#[pyo3(signature = (radius_mm, *, theta_deg = None, upr = None))]
pub(crate) fn trace_roundness<'py>(
    py: Python<'py>,
    radius_mm: &Bound<'py, PyAny>,
    theta_deg: Option<&Bound<'py, PyAny>>,
    upr: Option<u16>,
) -> PyResult<Bound<'py, PyAny>> {
    let count = radius_mm.len().unwrap_or(1);
    let radii = arrays::column(&units::in_unit(radius_mm, "radius_mm", "mm")?, "radius_mm", count, "the trace")?;
    let degrees = |given| units::in_unit(given, "theta_deg", "deg");
    let angles =
        theta_deg.map(|given| arrays::column(&degrees(given)?, "theta_deg", count, "radius_mm")).transpose()?;
    let (trace, found) = to_python(py.detach(|| {
        let trace = separation::Radii::of(&radii, angles.as_deref(), upr)?;
        let found = trace.evaluate(Path::new("radius_mm"))?;
        Ok((trace, found))
    }))?;
    trace.notes.iter().try_for_each(|note| warn(py, note))?;
    let document = dictionary(py, &found.document())?;
    document.set_item("theta_deg", PyArray1::from_vec(py, trace.theta_deg))?;
    document.set_item("radius_mm", PyArray1::from_vec(py, trace.radius_mm))?;
    result("Circle", document, Some(found.shown()))
}

/// Separate roundness and spindle error by three to six probes.
///
/// Parameters
/// ----------
/// readings : array-like
///     (revolutions × n, 3 to 6), one column for each probe, µm, equidistant in θ; with theta_deg, any number of rows.
/// n : int
///     Points per revolution, a power of two from 64 to 4096.
/// harmonics : tuple[int, int], optional
///     First and last harmonic of the profile, undulations per revolution, 2 or more and below n/2; by default, 2 to 100, or
///     to n/2 − 1.
/// p : int, optional
///     Slots of 360°/n from probe 1 to probe 2, 1 to n − 1.
/// q : int, optional
///     Slots of 360°/n from probe 2 to probe 3, 1 to n − 1.
/// phi2_deg : float, optional
///     Angle from probe 1 to probe 2 in the sense of θ, degrees, instead of p.
/// phi3_deg : float, optional
///     Angle from probe 2 to probe 3, degrees, instead of q.
/// arm : tuple[float, float, float], optional
///     Crank throw, wheel radius and pin radius in mm of an arm that follows the pin; by default, the arm is fixed.
/// upr : int, optional
///     Cut-off of the Gaussian filter in undulations per revolution: 15, 50, 150 or 500; by default, no filter.
/// noise_gain_limit : float, optional
///     Noise gain above which a harmonic is suppressed and marked; by default, 100.
/// theta_deg : array-like, optional
///     Increasing angles of the rows. The function resamples the readings; `resampling` states the
///     interpolation error.
/// angles_deg : list[float], optional
///     Angles of three to six probes from probe 1 in the sense of θ, degrees, instead of a pair. From four probes on
///     `agreement` states what they contradict one another by.
///
/// Returns
/// -------
/// Roundness
///     The document of `trueaxis roundness --json`, with the arrays profile_um, rx_um and ry_um (revolutions,
///     n).
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
#[pyfunction]
#[pyo3(signature = (readings, *, n, harmonics = None, p = None, q = None, phi2_deg = None, phi3_deg = None, arm = None,
    upr = None, noise_gain_limit = NOISE_GAIN_LIMIT, theta_deg = None, angles_deg = None))]
pub(crate) fn roundness<'py>(
    py: Python<'py>,
    readings: &Bound<'py, PyAny>,
    n: usize,
    harmonics: Option<[u16; 2]>,
    p: Option<i64>,
    q: Option<i64>,
    phi2_deg: Option<f64>,
    phi3_deg: Option<f64>,
    arm: Option<[f64; 3]>,
    upr: Option<u16>,
    noise_gain_limit: f64,
    theta_deg: Option<&Bound<'py, PyAny>>,
    angles_deg: Option<Vec<f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (count, values) = arrays::rows(&units::in_unit(readings, "readings", "um")?, "readings", &[3, 4, 5, 6])?;
    let rows = values.len() / count;
    let degrees = |given| units::in_unit(given, "theta_deg", "deg");
    let theta_deg =
        theta_deg.map(|given| arrays::column(&degrees(given)?, "theta_deg", rows, "readings")).transpose()?;
    let probes = Probes { n, harmonics, p, q, phi2_deg, phi3_deg, angles_deg };
    let request = separation::Request { probes, arm, upr, noise_gain_limit };
    let (evaluation, shown, separations) = to_python(py.detach(|| {
        let plan = request.plan()?;
        let needed = plan.arrangement().probes();
        anyhow::ensure!(count == needed, "readings: found {count} columns, needed {needed}, one for each angle");
        let probes: Vec<Vec<f64>> =
            (0..count).map(|probe| values.iter().skip(probe).step_by(count).copied().collect()).collect();
        let readings = match &theta_deg {
            Some(angles) => plan.resample(&probes.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>(), angles)?,
            None => {
                let whole = rows.is_multiple_of(n);
                anyhow::ensure!(whole, "readings: found {rows} rows, needed whole revolutions of {n} rows");
                separation::Readings { probes, resampling: None }
            }
        };
        let separations = plan.separate(&readings, || {})?;
        let evaluation = plan.evaluate(&separations, &readings)?;
        let shown = plan.shown(&evaluation);
        Ok((evaluation, shown, separations))
    }))?;
    let found = dictionary(py, &evaluation.document)?;
    let array = |of: fn(&trueaxis_metrology::separation::Separation) -> &Vec<f64>| {
        let all: Vec<f64> = separations.iter().flat_map(|parts| of(parts).iter().copied()).collect();
        PyArray1::from_vec(py, all).reshape([separations.len(), n])
    };
    found.set_item("profile_um", array(|parts| &parts.profile)?)?;
    found.set_item("rx_um", array(|parts| &parts.x)?)?;
    found.set_item("ry_um", array(|parts| &parts.y)?)?;
    result("Roundness", found, Some(shown))
}

/// Find the best angles of three probes.
///
/// Parameters
/// ----------
/// n : int
///     Points per revolution, a power of two from 64 to 4096.
/// harmonics : tuple[int, int], optional
///     First and last harmonic of the profile, undulations per revolution, 2 or more and below n/2; by default, 2 to 100, or
///     to n/2 − 1.
/// p : int, optional
///     Slots of 360°/n from probe 1 to probe 2, 1 to n − 1.
/// q : int, optional
///     Slots of 360°/n from probe 2 to probe 3, 1 to n − 1.
/// phi2_deg : float, optional
///     Angle from probe 1 to probe 2 in the sense of θ, degrees, instead of p.
/// phi3_deg : float, optional
///     Angle from probe 2 to probe 3, degrees, instead of q.
/// count : int, optional
///     Number of pairs listed, the best first.
///
/// Returns
/// -------
/// ProbeAngles
///     The document of `trueaxis probe-angles --json`, with the `count` best pairs of slots and, if the caller
///     states angles, the figures of that pair.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Examples
/// --------
/// >>> best = trueaxis.probe_angles(n=64).best[0]
/// >>> best.p, best.q
/// (5, 7)
#[pyfunction]
#[pyo3(signature = (*, n, harmonics = None, p = None, q = None, phi2_deg = None, phi3_deg = None,
    count = angles::USUAL_COUNT))]
pub(crate) fn probe_angles<'py>(
    py: Python<'py>,
    n: usize,
    harmonics: Option<[u16; 2]>,
    p: Option<i64>,
    q: Option<i64>,
    phi2_deg: Option<f64>,
    phi3_deg: Option<f64>,
    count: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let request =
        angles::Request { probes: Probes { n, harmonics, p, q, phi2_deg, phi3_deg, angles_deg: None }, count };
    let document = to_python(py.detach(|| request.search()?.run(|| {})))?;
    table_result("ProbeAngles", dictionary(py, &document)?, "Angles of three probes", (String::new(), document.table()))
}
