//! Traces over time, as an oscilloscope shows them.

use crate::recording::Recording;
use anyhow::{Context, Result, anyhow, ensure};
use plotters::prelude::*;
use std::path::Path;

const WIDTH: u32 = 1000;
const PANEL: u32 = 190;
const SCREEN: RGBColor = RGBColor(16, 20, 24);
const GRID: RGBColor = RGBColor(52, 60, 66);
const TEXT: RGBColor = RGBColor(200, 206, 210);
const TRACES: [RGBColor; 4] =
    [RGBColor(255, 214, 64), RGBColor(92, 214, 255), RGBColor(255, 110, 180), RGBColor(130, 255, 130)];
/// Columns of the screen: of each, the lowest and the highest sample are drawn.
const COLUMNS: usize = 900;

/// One panel: traces in a common unit.
struct Panel {
    unit: String,
    traces: Vec<(String, Vec<f64>)>,
}

/// Draws panels below each other: `UNIT*SCALE; LABEL = PIN [- PIN]; …`.
pub(crate) fn plot(
    recording: &Recording,
    panels: &[String],
    from_s: f64,
    to_s: f64,
    period_ns: u32,
    out: &Path,
) -> Result<()> {
    let period_s = f64::from(period_ns) * 1e-9;
    let last = recording.rows().len() as f64 * period_s;
    let (from_s, to_s) = (from_s.max(0.0), to_s.min(last));
    ensure!(from_s < to_s && !panels.is_empty(), "found {from_s} s to {to_s} s and {} panels", panels.len());
    let skip = (from_s / period_s) as usize;
    let take = ((to_s - from_s) / period_s) as usize;
    let height = PANEL * panels.len() as u32 + 20;
    let root = SVGBackend::new(out, (WIDTH, height)).into_drawing_area();
    root.fill(&SCREEN)?;
    for (text, area) in panels.iter().zip(root.split_evenly((panels.len(), 1))) {
        let panel = read(text, recording, skip, take)?;
        draw(&panel, &area, from_s, to_s).map_err(|error| anyhow!("{error}"))?;
    }
    root.present()?;
    Ok(())
}

fn read(text: &str, recording: &Recording, skip: usize, take: usize) -> Result<Panel> {
    let mut parts = text.split(';').map(str::trim);
    let unit = parts.next().unwrap_or_default();
    let (unit, scale) = unit.split_once('*').unwrap_or((unit, "1"));
    let scale: f64 = scale.trim().parse().with_context(|| format!("scale {scale:?}"))?;
    let traces = parts
        .map(|part| {
            let (label, pins) = part.split_once('=').with_context(|| format!("trace {part:?}: needed LABEL = PIN"))?;
            let (plus, minus) = pins.split_once(" - ").map_or((pins, None), |(plus, minus)| (plus, Some(minus)));
            let plus = recording.place(plus.trim())?;
            let minus = minus.map(|pin| recording.place(pin.trim())).transpose()?;
            let value = |row: &[f64]| scale * (row[plus] - minus.map_or(0.0, |place| row[place]));
            Ok((label.trim().to_owned(), recording.rows().skip(skip).take(take).map(value).collect()))
        })
        .collect::<Result<_>>()?;
    Ok(Panel { unit: unit.trim().to_owned(), traces })
}

/// Lowest and highest sample of every column, in their order.
fn thinned(values: &[f64], from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
    let step = values.len().div_ceil(COLUMNS).max(1);
    let at = |place: usize| from_s + (to_s - from_s) * place as f64 / values.len() as f64;
    let mut points = Vec::new();
    for (column, chunk) in values.chunks(step).enumerate() {
        let places = (0..chunk.len()).filter(|&i| chunk[i].is_finite());
        let low = places.clone().min_by(|&i, &j| chunk[i].total_cmp(&chunk[j]));
        let high = places.max_by(|&i, &j| chunk[i].total_cmp(&chunk[j]));
        let (Some(low), Some(high)) = (low, high) else { continue };
        for place in if low <= high { [low, high] } else { [high, low] } {
            points.push((at(column * step + place), chunk[place]));
        }
        if low == high {
            points.pop();
        }
    }
    points
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(panel: &Panel, area: &Area<'_>, from_s: f64, to_s: f64) -> Result<(), Box<dyn std::error::Error>> {
    let all = || panel.traces.iter().flat_map(|(_, values)| values.iter().copied()).filter(|v| v.is_finite());
    let (low, high) = all().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let room = 0.08 * (high - low).max(1e-9);
    let mut chart = ChartBuilder::on(area)
        .margin(6)
        .x_label_area_size(24)
        .y_label_area_size(64)
        .build_cartesian_2d(from_s..to_s, low - room..high + room)?;
    chart
        .configure_mesh()
        .axis_style(GRID)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 12).into_font().color(&TEXT))
        .y_desc(panel.unit.as_str())
        .x_labels(10)
        .y_labels(5)
        .x_label_formatter(&|t| format!("{t:.1} s"))
        .y_label_formatter(&|v| if high - low < 0.1 && *v != 0.0 { format!("{v:.0e}") } else { format!("{v:.1}") })
        .draw()?;
    for ((label, values), colour) in panel.traces.iter().zip(TRACES.iter().cycle()) {
        chart
            .draw_series(LineSeries::new(thinned(values, from_s, to_s), colour.stroke_width(1)))?
            .label(label.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(SCREEN.mix(0.8))
        .label_font(("sans-serif", 12).into_font().color(&TEXT))
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_spike_survives_the_thinning() {
        let mut values = vec![0.0; 100_000];
        values[54_321] = 7.0;
        values[54_322] = -3.0;
        values[9] = f64::NAN;
        let points = thinned(&values, 0.0, 100.0);
        assert!(points.len() <= 2 * COLUMNS);
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0));
        let spike = points.iter().find(|point| point.1 == 7.0).unwrap();
        assert!((spike.0 - 54.321).abs() < 1e-9);
        assert!(points.iter().any(|point| point.1 == -3.0));
    }
}
