//! Inputs, the flank's figures, the axes' travel and the points.

use crate::report::range;
use maud::{Markup, html};
use trueaxis_evaluation::helicoid::{HelicoidDocument, Job, Point, Range};
use trueaxis_report::{
    Row, Table,
    number::{count, decimals, shortest},
};
use trueaxis_tables::text::counted;

/// Decimals of displacements: a nanometre.
const DECIMALS: i32 = 6;
/// Most points in the table.
const SHOWN: usize = 400;

/// A value of a point.
type Of = fn(&Point) -> f64;

/// The five displacements by name, unit and value.
pub(super) const AXES: [(&str, &str, Of); 5] = [
    ("X", "mm", |point| point.x_mm),
    ("Y", "mm", |point| point.y_mm),
    ("Z", "mm", |point| point.z_mm),
    ("A", "degrees", |point| point.a_deg),
    ("C", "degrees", |point| point.c_deg),
];

fn row(name: &str, value: String, unit: &str) -> Row {
    Row::new(name, [value, unit.to_owned()])
}

pub(super) fn set_up(job: &Job) -> Table {
    let settings = &job.settings;
    let spoken = |range: Range| format!("{} to {}", shortest(range.start), shortest(range.stop));
    let mut rows = vec![row("pivot length L", shortest(settings.pivot_mm), "mm")];
    if let Some([travel, radius]) = job.edge_finder_mm {
        rows.push(row("edge finder: travel a", shortest(travel), "mm"));
        rows.push(row("edge finder: ball radius r", shortest(radius), "mm"));
    }
    rows.push(row("direction of A", settings.direction_a.to_string().replace('-', "−"), ""));
    rows.push(row("direction of C", settings.direction_c.to_string().replace('-', "−"), ""));
    rows.push(row("work offset X, Y, Z", settings.work_offset_mm.map(shortest).join(", "), "mm"));
    rows.push(row(&format!("u, {}", counted(job.u.count, "value")), spoken(job.u), "rad"));
    rows.push(row(&format!("θ, {}", counted(job.theta.count, "value")), spoken(job.theta), "rad"));
    Table::new(["set-up", "value", "unit"], rows).words(&[2])
}

pub(super) fn surface(job: &Job) -> Table {
    let mut rows = Vec::new();
    if let Some((_, data)) = &job.gear {
        rows.extend([
            row("transverse module", decimals(data.transverse_module_mm, DECIMALS), "mm"),
            row("transverse pressure angle", decimals(data.transverse_pressure_angle_deg, DECIMALS), "degrees"),
            row("reference radius", decimals(data.reference_radius_mm, DECIMALS), "mm"),
            row("base helix angle", decimals(data.base_helix_angle_deg, DECIMALS), "degrees"),
            row("|u| at the reference radius", decimals(data.reference_roll_angle_rad, DECIMALS), "rad"),
        ]);
    }
    let surface = &job.surface;
    rows.extend([
        row("base radius", decimals(surface.base_radius(), DECIMALS), "mm"),
        row("lead parameter", decimals(surface.lead_parameter(), DECIMALS), "mm/rad"),
        row("lead", decimals(std::f64::consts::TAU * surface.lead_parameter(), DECIMALS), "mm"),
        row("tilt γ of the normal", decimals(surface.tilt().to_degrees(), DECIMALS), "degrees"),
    ]);
    Table::new(["flank", "value", "unit"], rows).words(&[2])
}

/// Travel that the axes need over the grid.
pub(super) fn travel(document: &HelicoidDocument) -> Table {
    let rows = AXES.map(|(name, unit, of)| {
        let [low, high] = range(document.points.iter().map(of));
        let cells = [low, high, high - low].map(|value| decimals(value, DECIMALS));
        Row::new(name, cells.into_iter().chain([unit.to_owned()]))
    });
    Table::new(["travel", "from", "to", "length", "unit"], rows).words(&[4])
}

pub(super) fn points(document: &HelicoidDocument) -> Markup {
    let of = document.points.len();
    let every = of.div_ceil(SHOWN).max(1);
    let rows = document.points.iter().step_by(every).map(|point| {
        let cells = AXES.map(|(_, _, of)| decimals(of(point), DECIMALS));
        Row::new(shortest(point.u_rad), [shortest(point.theta_rad)].into_iter().chain(cells))
    });
    let heads = ["u, rad", "θ, rad", "X, mm", "Y, mm", "Z, mm", "A, degrees", "C, degrees"];
    html! {
        @if every > 1 {
            p { "One in " (count(every as u64)) " of " (count(of as u64)) " points; " code { "-o" } " writes all of them." }
        }
        (Table::new(heads, rows))
    }
}
