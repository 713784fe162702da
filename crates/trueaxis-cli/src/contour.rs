//! `trueaxis contour`.

use crate::csv_in::{self, Column, Row};
use crate::output::{Writer, tell};
use anyhow::{Result, anyhow, bail};
use clap::{Args, ValueEnum};
use serde::Deserialize;
use std::path::{Path as FilePath, PathBuf};
use trueaxis::contour::{ContourSearch, Flags, Method, Path, Reference, Segment, Span, convert, span_count};
use trueaxis::glam::DVec3;
use trueaxis_tables::text::{line_at, read_text};

pub(crate) const HELP: &str = "\
PATH.json: {\"segments\":[
  {\"type\":\"line\",\"start\":[x,y,z],\"end\":[x,y,z]},
  {\"type\":\"arc\",\"start\":[…],\"end\":[…],\"center\":[…],\"normal\":[…],\"turns\":0},    right hand about the normal; start = end: full circle
  {\"type\":\"nurbs\",\"degree\":3,\"knots\":[…],\"points\":[[x,y,z],…],\"weights\":[…]}]}    degree 1 to 5; mm
ACTUAL.csv: segment,u,x_mm,y_mm,z_mm; u is where the reference is: 0..1 on lines and arcs, the knot domain on NURBS.
Output: segment,u,error_um,ex_um,ey_um,ez_um,evaluations,bracketed: the foot point, its distance, the vector actual − foot.
A path is cut into spans within 8 mm of their middle that turn by 30° at most; it may have 1,000,000 (16 km straight).
The nearest point within --max-lag-mm of path length on either side of the reference is found, each row for itself.

Example: trueaxis contour path.json actual.csv -o error.csv";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Refinement {
    /// Newton steps guarded by bisection.
    Guarded,
    /// Plain bisection of the distance's derivative.
    Bisection,
}

#[derive(Args)]
pub(crate) struct Arguments {
    /// The programmed path.
    #[arg(value_name = "PATH.json")]
    path: PathBuf,
    /// Measured positions with the reference on the path.
    #[arg(value_name = "ACTUAL.csv")]
    actual: PathBuf,
    /// Method that narrows a bracket.
    #[arg(long, value_enum, default_value = "guarded")]
    method: Refinement,
    /// Path length searched on either side of the reference.
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    max_lag_mm: f64,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathFile {
    segments: Vec<SegmentFile>,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
enum SegmentFile {
    Line {
        start: [f64; 3],
        end: [f64; 3],
    },
    Arc {
        start: [f64; 3],
        end: [f64; 3],
        center: [f64; 3],
        #[serde(default = "z_axis")]
        normal: [f64; 3],
        #[serde(default)]
        turns: u32,
    },
    Nurbs {
        degree: usize,
        knots: Vec<f64>,
        #[serde(deserialize_with = "vectors")]
        points: Vec<DVec3>,
        #[serde(default)]
        weights: Vec<f64>,
    },
}

fn vectors<'de, D: serde::Deserializer<'de>>(points: D) -> Result<Vec<DVec3>, D::Error> {
    Ok(Vec::<[f64; 3]>::deserialize(points)?.into_iter().map(DVec3::from).collect())
}

fn z_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl SegmentFile {
    fn segment(&self) -> Segment<'_> {
        match self {
            SegmentFile::Line { start, end } => Segment::Line { start: (*start).into(), end: (*end).into() },
            SegmentFile::Arc { start, end, center, normal, turns } => Segment::Arc {
                start: (*start).into(),
                end: (*end).into(),
                center: (*center).into(),
                normal: (*normal).into(),
                turns: *turns,
            },
            SegmentFile::Nurbs { degree, knots, points, weights } => {
                Segment::Nurbs { degree: *degree, knots, points, weights }
            }
        }
    }
}

/// A path with the first span of every segment.
struct Converted {
    spans: Vec<Span<f64, f64>>,
    first: Vec<usize>,
    closed: bool,
}

/// Segments may be this far apart without a word, mm.
const JOINED: f64 = 1e-6;
/// Further than this they are no path, mm.
const GAP: f64 = 1e-3;
/// Most spans of a path: 16 km of straight line, 300 MB.
const MOST_SPANS: u64 = 1_000_000;

fn read_path(file: &FilePath) -> Result<Converted> {
    let text = read_text(file, &[])?;
    let parsed: PathFile = serde_json::from_str(&text)
        .map_err(|e| anyhow!("{}:{}: column {}: {e}", file.display(), e.line(), e.column()))?;
    if parsed.segments.is_empty() {
        bail!("{}: segments: found none, needed at least one", file.display());
    }
    let wrong = |number: usize, what: String| match segment_line(&text, number) {
        Some(line) => anyhow!("{}:{line}: segments[{number}]: {what}", file.display()),
        None => anyhow!("{}: segments[{number}]: {what}", file.display()),
    };
    // Everything is counted before anything is made.
    let mut total = 0;
    for (number, segment) in parsed.segments.iter().enumerate() {
        let count = span_count(&segment.segment()).map_err(|error| wrong(number, error.to_string()))?;
        total += u64::from(count);
        if total > MOST_SPANS {
            let found = format!("found {total} spans of the path up to here, each 16 mm or 30° at most");
            return Err(wrong(number, format!("{found}, needed at most {MOST_SPANS}")));
        }
    }
    let mut path = Converted { spans: Vec::with_capacity(total as usize), first: Vec::new(), closed: false };
    for (number, segment) in parsed.segments.iter().enumerate() {
        let start = path.spans.len();
        path.first.push(start);
        convert(&segment.segment(), number as u32, z_axis(), |span| {
            path.spans.push(span);
            Ok(())
        })
        .map_err(|error| wrong(number, error.to_string()))?;
        if path.spans.len() == start {
            return Err(wrong(number, "found no length, needed a path".into()));
        }
        if let Some(before) = start.checked_sub(1) {
            let gap = distance(path.spans[before].position(1.0), path.spans[start].position(0.0));
            if gap > GAP {
                let found = format!("start: found {gap} mm from the end of the segment before");
                return Err(wrong(number, format!("{found}, needed at most {GAP}")));
            }
            if gap > JOINED {
                tell(format_args!(
                    "note: {}: segments[{number}] starts {gap:.2e} mm from the end of the one before",
                    file.display()
                ));
            }
        }
    }
    path.first.push(path.spans.len());
    let (start, end) = (path.spans[0].position(0.0), path.spans[path.spans.len() - 1].position(1.0));
    path.closed = distance(start, end) <= JOINED;
    Ok(path)
}

/// The line on which a segment begins: only looked for to report an error.
fn segment_line(text: &str, number: usize) -> Option<u32> {
    #[derive(Deserialize)]
    struct Raw<'t> {
        #[serde(borrow)]
        segments: Vec<&'t serde_json::value::RawValue>,
    }
    let raw: Raw<'_> = serde_json::from_str(text).ok()?;
    let offset = (raw.segments.get(number)?.get().as_ptr() as usize).checked_sub(text.as_ptr() as usize)?;
    Some(line_at(text, offset))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

impl Converted {
    /// The reference at a segment's parameter, or the range that it must lie in.
    fn reference(&self, segment: usize, u: f64) -> Result<Reference<f64>, [f64; 2]> {
        let (first, end) = (self.first[segment], self.first[segment + 1]);
        let [low, high] = [self.spans[first].u_range()[0], self.spans[end - 1].u_range()[1]];
        // A reference that was printed with fewer digits may lie a hair outside.
        let slack = 1e-9 * (high - low);
        if !(low - slack..=high + slack).contains(&u) {
            return Err([low, high]);
        }
        let inside = self.spans[first..end].partition_point(|span| span.u_range()[1] < u);
        let span = (first + inside).min(end - 1);
        Ok(Reference { span: span as u32, t: self.spans[span].t_of(u) })
    }
}

const COLUMNS: [Column; 5] = [
    Column { name: "segment", needed: true },
    Column { name: "u", needed: true },
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
];

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let path = read_path(&arguments.path)?;
    let mut actual = csv_in::open(&arguments.actual, &COLUMNS, "positions")?;
    let method = match arguments.method {
        Refinement::Guarded => Method::Guarded,
        Refinement::Bisection => Method::Bisection,
    };
    let search = ContourSearch::new(arguments.max_lag_mm, method).map_err(|error| anyhow!("--max-lag-mm: {error}"))?;
    let view = Path::new(&path.spans, 0, path.closed);
    let segments = path.first.len() - 1;
    let inputs = [arguments.path.clone(), arguments.actual.clone()];
    let mut out = Writer::new(arguments.output.as_deref(), inputs)?;
    out.put(format_args!("segment,u,error_um,ex_um,ey_um,ez_um,evaluations,bracketed\n"))?;
    while let Some(Row { line, values: [segment, u, x, y, z] }) = actual.next()? {
        if segment.fract() != 0.0 || segment < 0.0 || segment >= segments as f64 {
            return Err(actual.error(line, "segment", segment, format!("a whole number from 0 to {}", segments - 1)));
        }
        let reference = path
            .reference(segment as usize, u)
            .map_err(|[low, high]| actual.error(line, "u", u, format!("{low} to {high} on this segment")))?;
        let found = search.nearest(&view, reference, [x, y, z]);
        let span = &path.spans[found.span as usize];
        let [ex, ey, ez] = found.vector.to_array().map(|e| e * 1e3);
        out.put(format_args!(
            "{},{},{},{ex},{ey},{ez},{},{}\n",
            span.segment(),
            span.u_of(found.t),
            found.error * 1e3,
            found.evaluations,
            found.flags.has(Flags::BRACKETED)
        ))?;
    }
    out.finish()
}
