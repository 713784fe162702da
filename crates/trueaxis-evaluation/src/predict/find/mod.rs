//! Features found in a program, for confirmation.

mod chain;
mod pass;
mod path;
mod repeated;
mod surface;

use super::part::Feature;
use path::Piece;
use std::fmt::Write as _;
use trueaxis_sim::program::Program;

/// What a program cuts.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The features as finished.
    pub features: Vec<Feature>,
    /// Passes that another one repeats later.
    pub left_out: Vec<LeftOut>,
}

/// A pass that is no feature, since a later one cuts the same.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// First and last line.
    pub lines: [u32; 2],
    /// Index of the feature that is cut last.
    pub feature: usize,
    /// Where it is, seen from that feature.
    pub why: String,
}

/// Features that the program cuts between two rapid motions: holes, full circles, planes milled line by line, free forms, and
/// otherwise the straight lines as edges. Of passes that cut the same one after the other, the last is the feature.
pub fn find(program: &Program) -> Found {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut from = 0;
    for pass in program.moves.chunk_by(|one, next| one.rapid == next.rapid) {
        if !pass[0].rapid {
            pieces.extend(pass::pieces(pass, from));
        }
        from += pass.len();
    }
    let mut once: Vec<Piece> = Vec::new();
    for piece in surface::joined(&program.moves, pieces) {
        // Lines of a loop or subprogram cut more than once.
        let again = |own: &Piece| own.lines[0] <= piece.lines[1] && piece.lines[0] <= own.lines[1];
        if !once.iter().any(again) {
            once.push(piece);
        }
    }
    let finishing = repeated::finishing(&program.moves, &once);
    let mut features: Vec<Feature> = Vec::new();
    let mut index = vec![0; once.len()];
    for (k, piece) in once.iter().enumerate().filter(|(k, _)| finishing[*k].is_none()) {
        let (kind, lines) = (piece.kind, piece.lines);
        let number = 1 + features.iter().filter(|own| own.kind == kind).count();
        index[k] = features.len();
        let name = format!("{} {number}", kind.name());
        features.push(Feature { name, kind, lines, setup: None, tool: None, side: None, gear: None, line: 0 });
    }
    let left_out = once.iter().zip(finishing).filter_map(|(piece, last)| {
        let (last, why) = last?;
        Some(LeftOut { lines: piece.lines, feature: index[last], why })
    });
    Found { left_out: left_out.collect(), features }
}

/// The features as sections of a part's file, with comments on the passes left out.
pub fn sections(found: &Found) -> String {
    let mut text = String::new();
    for (index, Feature { name, kind, lines: [from, to], .. }) in found.features.iter().enumerate() {
        text.push('\n');
        for LeftOut { lines: [from, to], why, .. } in found.left_out.iter().filter(|of| of.feature == index) {
            let lines = if from == to { format!("line {from}") } else { format!("lines {from} to {to}") };
            let _ = writeln!(text, "# {lines} left out: {why}, cut before {name}");
        }
        let kind = kind.name();
        let _ = write!(text, "[[feature]]\nname = \"{name}\"\nkind = \"{kind}\"\nlines = [{from}, {to}]\n");
    }
    text
}
