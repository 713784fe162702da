//! Tables of the uncertainty of the corrected position.

use super::{AtPoint, Spread, UncertaintyDocument};
use crate::shown::{Cell, Shown, Table};
use trueaxis_report::number::significant;

impl UncertaintyDocument {
    /// Tables of the document: the worst point, the requested position, contributions.
    pub fn shown(&self) -> Shown {
        let points = [("Worst point", Some(&self.worst)), ("Requested position", self.at.as_ref())];
        let points = points.into_iter().filter_map(|(name, point)| Some(self.spreads(name, point?)));
        let contributions = self.contributions.iter().map(|of| {
            let [rms, worst] = [of.rms_um, of.worst_um].map(|um| Cell::number(um, 3));
            vec![of.term.as_str().into(), Cell::percent(of.share), rms, worst]
        });
        let head = ["contribution", "share, %", "RMS over the volume, µm", "at the worst point, µm"];
        let contributions = Table::new("Contributions to the standard uncertainty", head, contributions).bars(1);
        let volume = self.volume_mm.iter().map(|(letter, ends)| format!("{letter} {} … {}", ends[0], ends[1]));
        let not_stated = format!("not stated, taken as zero: {}", self.not_stated.join(", "));
        Shown {
            title: "Uncertainty of the corrected position".into(),
            summary: vec![
                self.machine.clone(),
                format!("{} %", self.confidence_percent),
                format!("working volume {} mm", volume.collect::<Vec<_>>().join(", ")),
                format!("{} points", self.points),
                format!("standard uncertainty {} µm RMS", significant(self.standard_rms_um, 3)),
            ],
            notes: self.warnings.iter().cloned().chain((!self.not_stated.is_empty()).then_some(not_stated)).collect(),
            tables: points.chain([contributions]).collect(),
            ..Shown::default()
        }
    }

    /// Expanded uncertainties at a point by both methods.
    fn spreads(&self, name: &str, point: &AtPoint) -> Table {
        let row = |name: &str, of: &Spread| -> Vec<Cell> {
            let um = of.expanded_um.into_iter().chain([of.radius_um]).map(|um| Cell::number(um, 3));
            std::iter::once(name.into()).chain(um).collect()
        };
        let factor = point.jacobian.factor.map(|factors| {
            let cells = factors.map(|factor| Cell::fixed(factor, 3)).into_iter().chain(["".into()]);
            std::iter::once("factor k".into()).chain(cells).collect()
        });
        let rows = [row("by derivatives", &point.jacobian), row("by machines drawn", &point.monte_carlo)];
        let caption = format!("{name}, {}: expanded, {} %, µm", point.place(), self.confidence_percent);
        Table::new(caption, ["", "X", "Y", "Z", "radius"], rows.into_iter().chain(factor))
    }
}
