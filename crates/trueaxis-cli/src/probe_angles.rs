//! `trueaxis probe-angles`.

use crate::output::{json, print, progress};
use crate::probes::ProbeArgs;
use anyhow::Result;
use clap::Args;
use trueaxis_evaluation::probe_angles::{Request, USUAL_COUNT};

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
    if arguments.json { json(&document) } else { print(&document.table().to_string()) }
}
