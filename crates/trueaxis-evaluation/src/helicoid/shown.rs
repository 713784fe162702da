//! Tables of a flank and its displacements.

use super::HelicoidDocument;
use super::plots::{DISPLACEMENTS, displacements};
use crate::shown::{Cell, Shown, Table};
use trueaxis_report::number::{count, shortest};
use trueaxis_tables::text::counted;

/// Decimals of displacements: a nanometre.
const DECIMALS: i32 = 6;
/// Most points in the table.
const SHOWN: usize = 400;

fn fixed(value: f64) -> Cell {
    Cell::fixed(value, DECIMALS)
}

/// A table of values with their units.
fn values<'n>(caption: &str, rows: impl IntoIterator<Item = (&'n str, Cell, &'n str)>) -> Table {
    let rows = rows.into_iter().map(|(name, value, unit)| vec![name.into(), value, unit.into()]);
    Table::new(caption, ["", "value", "unit"], rows)
}

impl HelicoidDocument {
    /// Set-up, flank, travel over the grid, points, and plots of the displacements.
    pub fn shown(&self) -> Shown {
        let inputs = &self.inputs;
        let surface = match (inputs.module_mm, inputs.teeth, inputs.pressure_angle_deg, inputs.helix_angle_deg) {
            (Some(module), Some(teeth), Some(pressure), Some(helix)) => format!(
                "gear mₙ {} mm, z {teeth}, αₙ {}°, β {}°",
                shortest(module),
                shortest(pressure),
                shortest(helix)
            ),
            _ => format!(
                "base radius {} mm, lead parameter {} mm/rad",
                shortest(self.surface.base_radius_mm),
                shortest(self.surface.lead_parameter_mm_per_rad)
            ),
        };
        Shown {
            title: "Involute helicoid on five axes".into(),
            summary: vec![
                surface,
                format!("{} flank", inputs.flank),
                inputs.form.into(),
                format!("branch {}", inputs.branch),
                format!("{} points", count(self.points.len() as u64)),
            ],
            tables: vec![self.set_up(), self.flank(), self.travel(), self.grid()],
            plots: displacements(self),
            ..Shown::default()
        }
    }

    fn set_up(&self) -> Table {
        let inputs = &self.inputs;
        let offset = inputs.work_offset_mm.map(shortest).join(", ");
        let [u, theta] = [("u", inputs.u_rad), ("θ", inputs.theta_rad)].map(|(name, range)| {
            let ends = format!("{} to {}", shortest(range.start), shortest(range.stop));
            (format!("{name}, {}", counted(range.count, "value")), ends)
        });
        let finder = |name, mm: Option<f64>| mm.map(|mm| (name, Cell::shortest(mm), "mm"));
        let finder = [
            finder("edge finder: travel a", inputs.edge_finder_mm),
            finder("edge finder: ball radius r", inputs.edge_finder_radius_mm),
        ];
        let rows = [("pivot length L", Cell::shortest(inputs.pivot_mm), "mm")].into_iter();
        let rows = rows.chain(finder.into_iter().flatten()).chain([
            ("direction of A", Cell::shortest(inputs.direction_a.into()), ""),
            ("direction of C", Cell::shortest(inputs.direction_c.into()), ""),
            ("work offset X, Y, Z", offset.into(), "mm"),
            (u.0.as_str(), u.1.into(), "rad"),
            (theta.0.as_str(), theta.1.into(), "rad"),
        ]);
        values("Set-up", rows)
    }

    /// Values derived from the gear or the base circle.
    pub fn flank(&self) -> Table {
        let gear = self.gear.iter().flat_map(|gear| {
            [
                ("transverse module", fixed(gear.transverse_module_mm), "mm"),
                ("transverse pressure angle", fixed(gear.transverse_pressure_angle_deg), "degrees"),
                ("reference radius", fixed(gear.reference_radius_mm), "mm"),
                ("base helix angle", fixed(gear.base_helix_angle_deg), "degrees"),
                ("|u| at the reference radius", fixed(gear.reference_roll_angle_rad), "rad"),
            ]
        });
        let surface = &self.surface;
        let rows = gear.chain([
            ("base radius", fixed(surface.base_radius_mm), "mm"),
            ("lead parameter", fixed(surface.lead_parameter_mm_per_rad), "mm/rad"),
            ("lead", fixed(surface.lead_mm), "mm"),
            ("tilt γ of the normal", fixed(surface.tilt_deg), "degrees"),
            ("points of the grid", Cell::count(self.inputs.u_rad.count * self.inputs.theta_rad.count), ""),
        ]);
        values("Flank", rows)
    }

    /// Travel that the axes need over the grid.
    fn travel(&self) -> Table {
        let rows = DISPLACEMENTS.map(|(name, unit, of)| {
            let all = || self.points.iter().map(of);
            let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            vec![name.into(), fixed(low), fixed(high), fixed(high - low), unit.into()]
        });
        Table::new("Travel over the grid", ["axis", "from", "to", "length", "unit"], rows)
    }

    fn grid(&self) -> Table {
        let of = self.points.len();
        let every = of.div_ceil(SHOWN).max(1);
        let rows = self.points.iter().step_by(every).map(|point| {
            let angles = [point.u_rad, point.theta_rad].map(Cell::shortest);
            angles.into_iter().chain(DISPLACEMENTS.map(|(_, _, of)| fixed(of(point)))).collect()
        });
        let caption = match every {
            1 => "Points".into(),
            _ => format!("Points, one in {every} of {}; -o writes all of them", count(of as u64)),
        };
        let displacements = DISPLACEMENTS.map(|(name, unit, _)| format!("{name}, {unit}"));
        Table::new(caption, ["u, rad", "θ, rad"].map(String::from).into_iter().chain(displacements), rows)
    }
}
