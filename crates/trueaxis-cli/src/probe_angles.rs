//! `trueaxis probe-angles`.

use crate::output::{json, print, progress};
use crate::probes::ProbeArgs;
use anyhow::Result;
use clap::Args;
use std::fmt::Write;
use trueaxis_evaluation::probe_angles::{Pair, ProbeAnglesDocument, Request, USUAL_COUNT};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis probe-angles --n 1024 --harmonics 2..100 --p 188 --q 667";

pub(crate) const HELP: &str = "\
All pairs of slots are searched. The worst gain is the smallest |G(k)|/√(1 + k2² + k3²) in the band, 0 (blind) to \
√3. Its inverse, the worst noise gain, says how much the probes' noise grows in the worst harmonic. Of equal pairs \
the one with the smallest p comes first, then the smallest q. A given pair is compared with the best. A pair that \
cannot see some harmonics of the band is refused, and all of them are named.

Pairs for N = 1024 and harmonics 2..100:
  φ2, φ3            worst gain  worst noise gain
  90°, 181.05°           0.052              19.3  published (CN1927535)
  60.82°, 240.12°        0.053              18.7  published (CN1927535)
  59.414°, 66.094°       0.319               3.1  best: p 169, q 188
The best pair has 11 equivalents.";

#[derive(Args)]
pub(crate) struct ProbeAnglesArgs {
    #[command(flatten)]
    probes: ProbeArgs,
    /// Number of best pairs to list.
    #[arg(long, value_name = "COUNT", default_value_t = USUAL_COUNT)]
    count: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &ProbeAnglesArgs) -> Result<()> {
    let request = Request { probes: arguments.probes.asked(), count: arguments.count };
    let search = request.search()?;
    let bar = progress(search.steps() as u64, "arrangements of probes");
    let document = search.run(|| bar.inc(1));
    bar.finish_and_clear();
    let document = document?;
    if arguments.json { json(&document) } else { print(&table(&document)?) }
}

fn table(document: &ProbeAnglesDocument) -> Result<String> {
    let [first, last] = document.harmonics;
    let mut text = format!("N = {}, harmonics {first} to {last}\n\n", document.n);
    writeln!(
        text,
        "{:>5} {:>5} {:>11} {:>11} {:>11} {:>17} {:>12}",
        "p", "q", "φ2 in °", "φ3 in °", "worst gain", "worst noise gain", "at harmonic"
    )?;
    let mut line = |pair: &Pair| {
        let slot = |slot: Option<i64>| slot.map_or_else(|| "–".to_owned(), |slot| slot.to_string());
        writeln!(
            text,
            "{:>5} {:>5} {:>11.5} {:>11.5} {:>11.4} {:>17.3} {:>12}",
            slot(pair.p),
            slot(pair.q),
            pair.phi2_deg,
            pair.phi3_deg,
            pair.worst_gain,
            pair.worst_noise_gain,
            pair.worst_harmonic
        )
    };
    document.best.iter().try_for_each(&mut line)?;
    if let Some(given) = &document.pair {
        line(&given.pair)?;
        let percent = 100.0 * given.share_of_best;
        writeln!(text, "\nThe last line is the given pair: {percent:.1} % of the best worst gain.")?;
    }
    Ok(text)
}
