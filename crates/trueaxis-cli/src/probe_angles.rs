//! `trueaxis probe-angles`.

use crate::output::{json, print, progress};
use crate::probes::ProbeArgs;
use anyhow::Result;
use clap::Args;
use trueaxis_evaluation::probe_angles::{Request, USUAL_COUNT};
use trueaxis_evaluation::probe_places::{self, USUAL_STARTS};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis probe-angles --n 1024 --harmonics 2..100 --p 188 --q 667
  trueaxis probe-angles --n 1024 --probes 4 --apart-deg 12 --within-deg 240
  trueaxis probe-angles --n 1024 --probes 4 --angles-deg 0,37,131,253";

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
The best pair has 11 equivalents.

With --probes, --apart-deg, --within-deg or --angles-deg the search places three to six probes, numbered in the sense \
of θ from 0. The gain is that of least squares over all readings; each arrangement stands for its turned and mirrored \
images. The search starts at --starts random arrangements and moves one probe after the other; it proves no arrangement \
the best. The last column is the worst noise gain after the loss of any one probe.

Worst noise gain for N = 1024 and harmonics 2..100: three probes 3.1, four 1.2, five 0.77.";

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
    #[command(flatten)]
    places: PlaceArgs,
}

/// Three to six probes, and where they may stand.
#[derive(Args)]
#[group(conflicts_with_all = ["p", "q", "phi2_deg", "phi3_deg"], multiple = true)]
struct PlaceArgs {
    /// Number of probes, 3 to 6 [default: as many as --angles-deg, or 3].
    #[arg(long, value_name = "COUNT", help_heading = "Three to six probes")]
    probes: Option<usize>,
    /// Smallest angle between two probes.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Three to six probes")]
    apart_deg: Option<f64>,
    /// Sector in which all probes must stand [default: 360].
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Three to six probes")]
    within_deg: Option<f64>,
    /// Places to compare with the best, one for each probe.
    #[arg(
        long,
        value_name = "DEG,DEG,DEG…",
        value_delimiter = ',',
        allow_hyphen_values = true,
        help_heading = "Three to six probes"
    )]
    angles_deg: Option<Vec<f64>>,
    /// Random arrangements from which the search starts [default: 1000].
    #[arg(long, value_name = "COUNT", help_heading = "Three to six probes")]
    starts: Option<usize>,
}

impl PlaceArgs {
    fn are_given(&self) -> bool {
        let PlaceArgs { probes, apart_deg, within_deg, angles_deg, starts } = self;
        probes.is_some() || apart_deg.is_some() || within_deg.is_some() || angles_deg.is_some() || starts.is_some()
    }

    fn request(&self, probes: &ProbeArgs, count: usize) -> probe_places::Request {
        let asked = probes.asked();
        let given = self.angles_deg.as_ref().map(Vec::len);
        probe_places::Request {
            n: asked.n,
            harmonics: asked.harmonics,
            probes: self.probes.or(given).unwrap_or(3),
            apart_deg: self.apart_deg,
            within_deg: self.within_deg,
            angles_deg: self.angles_deg.clone(),
            count,
            starts: self.starts.unwrap_or(USUAL_STARTS),
        }
    }
}

pub(crate) fn run(arguments: &ProbeAnglesArgs) -> Result<()> {
    if arguments.places.are_given() {
        return places(arguments);
    }
    let request = Request { probes: arguments.probes.asked(), count: arguments.count };
    let search = request.search()?;
    let bar = progress(search.steps() as u64, "arrangements of probes");
    let document = search.run(|| bar.inc(1));
    bar.finish_and_clear();
    let document = document?;
    if arguments.json { json(&document) } else { print(&document.table().to_string()) }
}

fn places(arguments: &ProbeAnglesArgs) -> Result<()> {
    let search = arguments.places.request(&arguments.probes, arguments.count).search()?;
    let bar = progress(search.steps(), "starts of the search");
    let document = search.run(|| bar.inc(1));
    bar.finish_and_clear();
    let document = document?;
    if arguments.json { json(&document) } else { print(&document.table().to_string()) }
}
