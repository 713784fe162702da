//! `trueaxis uncertainty` with correlated terms, by hand: along X the tip moves by s x − c y, s the scale of X, c the
//! squareness of X and Y.

use std::path::Path;
use trueaxis_evaluation::uncertainty::{Options, UncertaintyDocument, evaluate};
use trueaxis_metrology::uncertainty::student_factor;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Standard uncertainties of scale and squareness, µm per mm.
const S: f64 = 3e-3;
const C: f64 = 5e-3;
const AT: [f64; 2] = [100.0, 100.0];
/// Grid points over 0 to 200 mm.
const GRID: [f64; 9] = [0.0, 25.0, 50.0, 75.0, 100.0, 125.0, 150.0, 175.0, 200.0];

fn found(coefficient: Option<f64>, [scale, squareness]: [u32; 2]) -> UncertaintyDocument {
    let mut machine = format!(
        "name = \"small\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntravel_mm = [0, 200]\n[axis.Y]\ntravel_mm = [0, 200]\n\
         [axis.Z]\ntravel_mm = [-100, 0]\n[uncertainty.location]\nC0Y_urad = 5\nC0Y_degrees_of_freedom = {squareness}\n\
         [axis.X.uncertainty]\nscale_ppm = 3\nscale_degrees_of_freedom = {scale}\n"
    );
    if let Some(r) = coefficient {
        machine += &format!(
            "[[uncertainty.correlation]]\nbetween = [\"axis.X.uncertainty.scale_ppm\", \
             \"uncertainty.location.C0Y_urad\"]\ncoefficient = {r}\n"
        );
    }
    let files = Memory::new([("machine.toml", machine.as_str())]);
    let toml = Path::new("machine.toml");
    let machine = Machine::read_from(&files, toml, &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&files, toml).unwrap();
    let at = Some([AT[0], AT[1], -50.0, 0.0, 0.0, 0.0]);
    evaluate(&machine, &stated, &Options { at, trials: 10_000, ..Options::default() }).unwrap()
}

#[test]
fn correlated_terms_as_by_hand() {
    let [s, c] = [S * AT[0], C * AT[1]];
    let cases =
        [(None, [6, 6]), (Some(0.6), [6, 6]), (Some(0.6), [6, 30]), (Some(-0.8), [12, 12]), (Some(1.0), [6, 6])];
    for (coefficient, degrees) in cases {
        let r = coefficient.unwrap_or(0.0);
        let found = found(coefficient, degrees);
        let at = found.at.as_ref().unwrap();
        let variance = s * s + c * c - 2.0 * r * s * c;
        let case = format!("{coefficient:?} {degrees:?}");
        let standard = at.jacobian.standard_um[0];
        assert!((standard / variance.sqrt() - 1.0).abs() < 1e-6, "{case}: {standard} for {}", variance.sqrt());
        let parts = [s * s - r * s * c, c * c - r * s * c];
        let nu = degrees.map(f64::from);
        let of_two = variance * variance / (parts[0].powi(2) / nu[0] + parts[1].powi(2) / nu[1]);
        // Of one fit, both are wrong by the same factor; the fewer degrees of freedom count.
        let wanted = if coefficient.is_some() { nu[0].min(nu[1]) } else { of_two };
        let effective = at.jacobian.degrees_of_freedom.unwrap()[0].unwrap();
        assert!((effective / wanted - 1.0).abs() < 1e-6, "{case}: {effective} for {wanted}");
        // Of one fit the distribution is Student's; of several, Welch and Satterthwaite's sum only comes near.
        if coefficient.is_some() {
            let expanded = student_factor(0.95, wanted) * variance.sqrt();
            let drawn = at.monte_carlo.expanded_um[0];
            assert!((drawn / expanded - 1.0).abs() < 0.04, "{case}: {drawn} drawn for {expanded}");
        }
        // Over the volume: Σ x² = Σ y², and Σ x y is less.
        let of = |part: &dyn Fn(f64, f64) -> f64| -> f64 {
            GRID.iter().flat_map(|x| GRID.iter().map(move |y| part(*x, *y))).sum()
        };
        let scale = of(&|x, y| S * x * (S * x - r * C * y));
        let squareness = of(&|x, y| C * y * (C * y - r * S * x));
        for (term, part) in [("scale X", scale), ("C0Y", squareness)] {
            let share = found.contributions.iter().find(|one| one.term == term).unwrap().share;
            let wanted = part / (scale + squareness);
            assert!((share - wanted).abs() < 1e-6, "{case}, {term}: {share} for {wanted}");
        }
        let says = found.warnings.iter().any(|one| one.starts_with("scale X, C0Y are correlated"));
        assert_eq!(says, coefficient.is_some(), "{:?}", found.warnings);
    }
    // Half of what both have in common is more than the scale has by itself.
    let scale = found(Some(0.9), [6, 6]).contributions.into_iter().find(|one| one.term == "scale X").unwrap();
    assert!(scale.share < -0.02 && scale.rms_um > 0.0, "{scale:?}");
}
