//! Tables of a calibration.

use super::document::Document;
use crate::shown::{Cell, EXPANDED, Quantity, Shown, Table, Uncertainty};

impl Document {
    /// Tables of the document: terms, artefacts, network.
    pub fn shown(&self) -> Shown {
        let known = |standard_error: f64| Uncertainty::of(standard_error, self.degrees_of_freedom as f64);
        let terms = self
            .terms
            .iter()
            .map(|term| Quantity::new(term.name.as_str(), term.unit, term.value, known(term.standard_error)));
        let tip = known(1e-3 * self.tip_radius_standard_error_um);
        let tip = Quantity::new("radius of the tip", "mm", self.tip_radius_mm, tip);
        let sizes = self.artefacts.iter().map(|size| {
            let found = Cell::fixed(size.found, 5);
            vec![size.name.as_str().into(), Cell::shortest(size.stated), found, known(size.standard_error).cell()]
        });
        let head = ["artefact", "stated", "found", &format!("{EXPANDED}, µm or µrad")];
        let sizes = Table::new("Artefacts, mm or °", head, sizes);
        let network = [
            ("sigma of a touch, µm", Cell::number(self.sigma_um, 3)),
            ("stated, µm", Cell::number(self.repeatability_um, 3)),
            ("measured, µm RMS", Cell::number(self.signal_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("unknowns, rank", Cell::count(self.rank)),
            ("condition", Cell::number(self.condition, 2)),
        ];
        let compensated = self.compensated.then(|| "compensated while probed".to_owned());
        let touches = format!("{} touches on {}", self.touches, self.machine);
        Shown {
            title: "Calibration".into(),
            summary: std::iter::once(touches).chain(compensated).collect(),
            notes: self.warnings.clone(),
            tables: vec![Table::quantities("Terms", terms.chain([tip])), Table::figures("Network", network), sizes],
            plots: Vec::new(),
            map: None,
        }
    }
}
