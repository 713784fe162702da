//! Times the separation of a record on one core: `separation N P Q FIRST LAST ARM_RATIO READINGS OUT`.
//!
//! READINGS: h1, h2 and h3 of all revolutions one after the other, f64, little-endian; OUT: r, R_X and R_Y the same way.
//! Prints the best of twenty runs, s. `benches/separation.py` makes both and compares them with numpy.

use std::io::Error;
use std::time::Instant;
use trueaxis::roundness::{Band, ProbeAngles};
use trueaxis_metrology::separation::{NOISE_GAIN_LIMIT, Separation, Separator};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [n, p, q, first, last, ratio, readings, out] = arguments.as_slice() else {
        return Err("needed N P Q FIRST LAST ARM_RATIO READINGS OUT".into());
    };
    let points: usize = n.parse()?;
    let gain = ProbeAngles::Slots { p: p.parse()?, q: q.parse()? }.resolve(points)?;
    let band = Band { first: first.parse()?, last: last.parse()? };
    let separator = Separator::new(gain, band, NOISE_GAIN_LIMIT, ratio.parse()?)?;
    let bytes = std::fs::read(readings)?;
    let values: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let third = values.len() / 3;
    let [h1, h2, h3] = [0, 1, 2].map(|probe| &values[probe * third..(probe + 1) * third]);
    let separate = || -> Result<Vec<Separation>, Box<dyn std::error::Error>> {
        let mut workspace = separator.workspace();
        let revolutions = h1.chunks_exact(points).zip(h2.chunks_exact(points)).zip(h3.chunks_exact(points));
        revolutions.map(|((h1, h2), h3)| Ok(separator.separate_in(&mut workspace, &[h1, h2, h3])?)).collect()
    };
    let mut best = f64::INFINITY;
    let mut found = separate()?;
    for _ in 0..20 {
        let start = Instant::now();
        found = separate()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    let part = |part: fn(&Separation) -> &Vec<f64>| found.iter().flat_map(part).flat_map(|value| value.to_le_bytes());
    let all: Vec<u8> = part(|of| &of.profile).chain(part(|of| &of.x)).chain(part(|of| &of.y)).collect();
    std::fs::write(out, all).map_err(|error: Error| format!("{out}: {error}"))?;
    println!("{best}");
    Ok(())
}
