//! A programmed path from its JSON text, cut into spans.

mod foot;

pub use foot::{Alive, Foot, NotOnPath, StuckAxis};

use anyhow::{Result, anyhow, bail};
use serde::Deserialize;
use std::path::Path as FilePath;
use trueaxis::contour::{Path, Reference, Segment, Span, convert, span_count};
use trueaxis::glam::DVec3;
use trueaxis_tables::text::{line_at, one_line};

/// Largest gap between segments that is not reported, mm.
const JOINED: f64 = 1e-6;
/// Shorter lines count as points, mm: the core refuses them.
const NO_LENGTH: f64 = 1e-9;
/// A larger gap between segments is an error, mm.
const GAP: f64 = 1e-3;
/// Maximum length of a message on malformed text, characters: the message may repeat a key from the text.
const LONGEST: usize = 400;
/// Maximum number of spans of a path: 16 km of straight line, 300 MB.
pub const MOST_SPANS: u64 = 1_000_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathText {
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
    /// A line from a point to itself, as machine-generated programs contain.
    fn is_a_point(&self) -> bool {
        matches!(self, SegmentFile::Line { start, end } if distance(*start, *end) < NO_LENGTH)
    }

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

/// The text of a path, its segments checked one by one and their spans counted but not yet created.
pub struct PathFile<'t> {
    text: &'t str,
    file: &'t FilePath,
    segments: Vec<SegmentFile>,
    total: u64,
}

impl<'t> PathFile<'t> {
    /// Reads `{"segments":[…]}` with lines, arcs and NURBS (mm); `file` is only named in errors.
    ///
    /// # Errors
    /// With line and segment: malformed text, a segment that is not a path, more than [`MOST_SPANS`].
    pub fn read(text: &'t str, file: &'t FilePath) -> Result<Self> {
        let PathText { segments } = serde_json::from_str(text).map_err(|e| {
            anyhow!("{}:{}: column {}: {}", file.display(), e.line(), e.column(), one_line(&e.to_string(), LONGEST))
        })?;
        if segments.is_empty() {
            bail!("{}: segments: found none, needed at least one", file.display());
        }
        let mut path = PathFile { text, file, segments, total: 0 };
        for (number, segment) in path.segments.iter().enumerate().filter(|(_, segment)| !segment.is_a_point()) {
            let count = span_count(&segment.segment()).map_err(|error| path.wrong(number, error.to_string()))?;
            path.total += u64::from(count);
            if path.total > MOST_SPANS {
                let found = format!("found {} spans of the path up to here, each 16 mm or 30° at most", path.total);
                return Err(path.wrong(number, format!("{found}, needed at most {MOST_SPANS}")));
            }
        }
        if path.total == 0 {
            return Err(path.wrong(0, "end: found no length, needed a path".into()));
        }
        Ok(path)
    }

    /// Upper bound on the number of spans that [`PathFile::cut`] creates.
    pub fn span_count(&self) -> u64 {
        self.total
    }

    /// Cuts the segments into spans; `note` receives remarks on segments that start slightly off the end of the previous one,
    /// and on lines without length, which keep their number and are skipped.
    ///
    /// # Errors
    /// With line and segment: a segment without length, or one that starts more than 1 µm from the end of the previous one.
    pub fn cut(&self, note: &mut dyn FnMut(String)) -> Result<ProgrammedPath> {
        let mut path =
            ProgrammedPath { spans: Vec::with_capacity(self.total as usize), first: Vec::new(), closed: false };
        for (number, segment) in self.segments.iter().enumerate() {
            let start = path.spans.len();
            path.first.push(start);
            if segment.is_a_point() {
                note(self.wrong(number, "a line without length, left out".into()).to_string());
                continue;
            }
            convert(&segment.segment(), number as u32, z_axis(), |span| {
                path.spans.push(span);
                Ok(())
            })
            .map_err(|error| self.wrong(number, error.to_string()))?;
            if path.spans.len() == start {
                return Err(self.wrong(number, "found no length, needed a path".into()));
            }
            if let Some(before) = start.checked_sub(1) {
                let gap = distance(path.spans[before].position(1.0), path.spans[start].position(0.0));
                if gap > GAP {
                    let found = format!("start: found {gap} mm from the end of the segment before");
                    return Err(self.wrong(number, format!("{found}, needed at most {GAP}")));
                }
                if gap > JOINED {
                    let file = self.file.display();
                    note(format!("{file}: segments[{number}] starts {gap:.2e} mm from the end of the one before"));
                }
            }
        }
        path.first.push(path.spans.len());
        let (start, end) = (path.spans[0].position(0.0), path.spans[path.spans.len() - 1].position(1.0));
        path.closed = distance(start, end) <= JOINED;
        Ok(path)
    }

    fn wrong(&self, number: usize, what: String) -> anyhow::Error {
        match segment_line(self.text, number) {
            Some(line) => anyhow!("{}:{line}: segments[{number}]: {what}", self.file.display()),
            None => anyhow!("{}: segments[{number}]: {what}", self.file.display()),
        }
    }
}

/// The line on which a segment begins; searched for only to report an error.
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

/// A path with the index of every segment's first span.
pub struct ProgrammedPath {
    spans: Vec<Span<f64, f64>>,
    first: Vec<usize>,
    closed: bool,
}

impl ProgrammedPath {
    /// All spans in path order.
    pub fn spans(&self) -> &[Span<f64, f64>] {
        &self.spans
    }

    /// The path to search on, closed if it ends within 1 nm of its start.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(&self.spans, 0, self.closed)
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.first.len() - 1
    }

    /// The reference at parameter `u` of a segment, numbered from 0.
    ///
    /// # Errors
    /// The range in which `u` must lie.
    ///
    /// # Panics
    /// If the segment does not exist.
    pub fn reference(&self, segment: usize, u: f64) -> Result<Reference<f64>, [f64; 2]> {
        let (first, end) = (self.first[segment], self.first[segment + 1]);
        if first == end {
            // A line without length is at the end of the previous segment, or at the start of the path.
            let t = if first == 0 { 0.0 } else { 1.0 };
            return if (0.0..=1.0).contains(&u) {
                Ok(Reference { span: first.saturating_sub(1) as u32, t })
            } else {
                Err([0.0, 1.0])
            };
        }
        let [low, high] = [self.spans[first].u_range()[0], self.spans[end - 1].u_range()[1]];
        // A reference printed with fewer digits may be slightly outside.
        let slack = 1e-9 * (high - low);
        if !(low - slack..=high + slack).contains(&u) {
            return Err([low, high]);
        }
        let inside = self.spans[first..end].partition_point(|span| span.u_range()[1] < u);
        let span = (first + inside).min(end - 1);
        Ok(Reference { span: span as u32, t: self.spans[span].t_of(u) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        let read = PathFile::read(text, FilePath::new("path.json")).and_then(|path| path.cut(&mut |_| {}));
        read.err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn a_line_without_length_is_left_out_and_reported() {
        let line =
            |start: [f64; 3], end: [f64; 3]| format!("{{\"type\":\"line\",\"start\":{start:?},\"end\":{end:?}}}");
        let (a, b, c) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]);
        let text = format!("{{\"segments\":[{},\n{},{},{}]}}", line(a, a), line(a, b), line(b, b), line(b, c));
        let mut notes = Vec::new();
        let path = PathFile::read(&text, FilePath::new("p.json")).unwrap().cut(&mut |note| notes.push(note)).unwrap();
        assert_eq!(
            notes,
            [
                "p.json:1: segments[0]: a line without length, left out",
                "p.json:2: segments[2]: a line without length, left out"
            ]
        );
        assert_eq!((path.segments(), path.spans().len()), (4, 2));
        let at = |segment, u| path.reference(segment, u).map(|at| (at.span, at.t));
        assert_eq!(
            [at(0, 0.5), at(1, 0.5), at(2, 0.5), at(3, 0.5)],
            [Ok((0, 0.0)), Ok((0, 0.5)), Ok((0, 1.0)), Ok((1, 0.5))]
        );
        assert_eq!(at(2, 1.5), Err([0.0, 1.0]));
        let alone = format!("{{\"segments\":[{}]}}", line(a, a));
        assert_eq!(refusal(&alone), "path.json:1: segments[0]: end: found no length, needed a path");
    }

    #[test]
    fn a_refusal_names_segment_and_line_and_stays_on_one() {
        let key = "k".repeat(4000);
        for (text, said) in [
            ("{\"segments\":[]}", "path.json: segments: found none"),
            ("{\"a\\nb\":1}", "path.json:1: column 7: unknown field `a\\nb`, expected `segments`"),
            (&format!("{{\"{key}\":1}}"), "kkk…"),
            (
                "{\"segments\":[\n{\"type\":\"line\",\"start\":[0,0,0],\"end\":[1,0,0]},\n\
                 {\"type\":\"line\",\"start\":[2,0,0],\"end\":[3,0,0]}]}",
                "path.json:3: segments[1]: start: found 1 mm from the end",
            ),
            (
                "{\"segments\":[{\"type\":\"line\",\"start\":[0,0,0],\"end\":[2e7,0,0]}]}",
                "segments[0]: end: found 20000000",
            ),
        ] {
            let refusal = refusal(text);
            assert!(refusal.contains(said) && !refusal.contains('\n'), "{refusal}");
        }
    }

    #[test]
    fn spans_are_counted_before_they_are_made_and_found_by_segment_and_parameter() {
        let text = "{\"segments\":[{\"type\":\"line\",\"start\":[0,0,0],\"end\":[40,0,0]},\
            {\"type\":\"arc\",\"start\":[40,0,0],\"end\":[40,0,0],\"center\":[40,5,0]}]}";
        let file = PathFile::read(text, FilePath::new("path.json")).unwrap();
        let path = file.cut(&mut |note| panic!("{note}")).unwrap();
        // Three parts of at most 16 mm; thirteen of slightly less than 30 degrees.
        assert_eq!((file.span_count(), path.spans().len(), path.segments()), (16, 16, 2));
        let at = path.reference(0, 0.75).unwrap();
        assert!(at.span == 2 && (at.t - 0.25).abs() < 1e-12, "{at:?}");
        assert_eq!(path.reference(1, 1.5).unwrap_err(), [0.0, 1.0]);
    }
}
