//! Recognises programs of controls with another language.

use super::error::Refusal;

const GCODE: &str = "G-code (RS274/NGC), as posts write it for LinuxCNC or Fanuc";

/// Lines in which a language shows.
const FIRST_LINES: usize = 40;

/// Words of Siemens' language that G-code has not.
const SIEMENS: [&str; 10] =
    ["DEF REAL", "DEF INT", "CYCLE8", "MCALL", "TRAORI", "CYCLE800", "WORKPIECE(", "SUPA", "MSG(", "EXTERN "];

/// The refusal of a program, which names the language if it is another control's.
pub(super) fn named(bytes: &[u8], file: &str, refusal: Refusal) -> Refusal {
    let lines = (1_u32..).zip(bytes.split(|byte| *byte == b'\n')).take(FIRST_LINES);
    for (line, bytes) in lines {
        let text = String::from_utf8_lossy(bytes).trim().to_ascii_uppercase();
        if text.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start().starts_with("BEGIN PGM") {
            return Refusal::new(line, format!("`{text}`, the beginning of a Heidenhain program"), GCODE);
        }
        if text.starts_with("%_N_") || SIEMENS.iter().any(|word| text.contains(word)) {
            return siemens(refusal);
        }
    }
    let suffix = file.rsplit_once('.').map_or("", |(_, suffix)| suffix);
    if ["mpf", "spf"].iter().any(|siemens| suffix.eq_ignore_ascii_case(siemens)) { siemens(refusal) } else { refusal }
}

fn siemens(refusal: Refusal) -> Refusal {
    Refusal {
        found: format!("{} in a program in Siemens' language", refusal.found),
        needed: GCODE.to_owned(),
        ..refusal
    }
}
