//! POINTS.csv: measured points.

use crate::record;
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use std::collections::{HashMap, HashSet};

/// Columns of the points.
pub const COLUMNS: [Column; 10] = [
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "actual_x_mm", needed: true },
    Column { name: "actual_y_mm", needed: true },
    Column { name: "actual_z_mm", needed: true },
    Column { name: "u_um", needed: false },
    Column { name: "tool_x_mm", needed: false },
    Column { name: "tool_y_mm", needed: false },
    Column { name: "tool_z_mm", needed: false },
];

/// Deviation beyond which a point is rejected, mm: coordinates in another frame, or an interrupted beam.
const MOST_DEVIATION_MM: f64 = 2.0;
/// Standard uncertainty if none is stated, mm: only its ratio to the others matters.
const UNIT_SIGMA_MM: f64 = 1e-3;

/// Share of missing lattice points above which the gaps are intended.
const LEFT_OUT: f64 = 0.01;

/// Refuses a lattice with missing points, up to one in a hundred.
fn lattice(rows: &Rows<'_, 10>, points: &[Point], tools: usize) -> Result<()> {
    for tool in 0..tools {
        let own = || points.iter().filter(|point| point.tool == tool).map(|point| point.command_mm);
        let levels = [0, 1, 2].map(|c| {
            let mut levels: Vec<f64> = own().map(|command| command[c]).collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup();
            levels
        });
        let (found, [nx, ny, nz]) = (own().count(), [0, 1, 2].map(|c| levels[c].len()));
        let plan = nx.saturating_mul(ny).saturating_mul(nz);
        if [nx, ny, nz].contains(&1) || found >= plan || (plan - found) as f64 > LEFT_OUT * plan as f64 {
            continue;
        }
        let there: HashSet<[u64; 3]> = own().map(|command| command.map(|mm| (mm + 0.0).to_bits())).collect();
        let all = (0..plan).map(|k| [levels[0][k % nx], levels[1][k / nx % ny], levels[2][k / nx / ny]]);
        if let Some([x, y, z]) = all.into_iter().find(|at| !there.contains(&at.map(|mm| (mm + 0.0).to_bits()))) {
            return Err(anyhow!(
                "{}: found {found} of {plan} points, none at X {x}, Y {y}, Z {z} mm, needed all of {nx} by {ny} by {nz} levels",
                rows.file.display()
            ));
        }
    }
    Ok(())
}

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Line of the file.
    pub line: u32,
    /// Commanded position of X, Y, Z, mm.
    pub command_mm: [f64; 3],
    /// Actual minus commanded position, without the reflector's offset, mm.
    pub deviation_mm: [f64; 3],
    /// Standard uncertainty of the point, mm; 1 µm if none is stated.
    pub sigma_mm: f64,
    /// Index of the point's reflector offset.
    pub tool: usize,
}

/// All points of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// The points, in the order of the file.
    pub points: Vec<Point>,
    /// Reflector offsets from the last tool-side frame, mm; `None`: the file has none, and the machine's tool is used.
    pub tools_mm: Vec<Option<[f64; 3]>>,
    /// Whether uncertainties are stated.
    pub stated: bool,
}

impl Points {
    /// Reads all rows of [`COLUMNS`].
    ///
    /// # Errors
    /// A row that cannot be read, a repeated point, an invalid uncertainty, a deviation of millimetres, coordinates that stop
    /// changing, a lattice with a missing point.
    pub fn read(rows: &mut Rows<'_, 10>) -> Result<Points> {
        let with_tool = rows.present[7..].iter().any(|present| *present);
        let stated = rows.present[6];
        let mut points: Vec<Point> = Vec::new();
        let mut tools_mm: Vec<Option<[f64; 3]>> = Vec::new();
        let mut lines = HashMap::new();
        while let Some(row) = rows.next()? {
            let [x, y, z, ax, ay, az, u_um, tx, ty, tz] = row.values;
            if stated && !(1e-6..=1e4).contains(&u_um) {
                return Err(rows.error(row.line, "u_um", u_um, "a standard uncertainty of 1e-6 to 10000 µm"));
            }
            let offset = with_tool.then_some([tx, ty, tz]);
            let tool = tools_mm.iter().position(|known| *known == offset).unwrap_or_else(|| {
                tools_mm.push(offset);
                tools_mm.len() - 1
            });
            let key = [x, y, z, tool as f64].map(|value| (value + 0.0).to_bits());
            if let Some(first) = lines.insert(key, row.line) {
                let found = format!("a second row for this position, as in line {first}");
                return Err(rows.error(row.line, "x_mm", found, "each position once for a reflector"));
            }
            let [tx, ty, tz] = offset.unwrap_or_default();
            let deviation_mm = [ax - x - tx, ay - y - ty, az - z - tz];
            for (deviation, name) in deviation_mm.into_iter().zip(["actual_x_mm", "actual_y_mm", "actual_z_mm"]) {
                if deviation.abs() > MOST_DEVIATION_MM {
                    let needed =
                        format!("less than {MOST_DEVIATION_MM} mm, in the machine's directions from machine zero");
                    return Err(rows.error(row.line, name, format!("{deviation} mm off the command"), needed));
                }
            }
            let sigma_mm = if stated { 1e-3 * u_um } else { UNIT_SIGMA_MM };
            points.push(Point { line: row.line, command_mm: [x, y, z], deviation_mm, sigma_mm, tool });
        }
        for (c, name) in ["actual_x_mm", "actual_y_mm", "actual_z_mm"].into_iter().enumerate() {
            // A coordinate that follows its axis differs from point to point; a dead instrument repeats its value while the
            // axis moves.
            let actual: Vec<f64> = points.iter().map(|point| point.command_mm[c] + point.deviation_mm[c]).collect();
            let moved = |stuck: &record::Stuck| {
                let over = points[stuck.from..stuck.from + stuck.count].iter().map(|point| point.command_mm[c]);
                let [low, high] = over.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], q| [l.min(q), h.max(q)]);
                high > low
            };
            if let Some(stuck) = record::longest(&actual).filter(moved) {
                let lines: Vec<u32> = points.iter().map(|point| point.line).collect();
                return Err(stuck.error(rows, &lines, name, 1.0));
            }
        }
        lattice(rows, &points, tools_mm.len())?;
        Ok(Points { points, tools_mm, stated })
    }
}
