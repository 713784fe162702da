//! Errors on a grid: as given, and as 16-bit numbers with a resolution.

use trueaxis::machine::{Axis, GridAxis, GridData, GridHeader, Twist};

/// The linear axes that grids can cover.
pub(crate) const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Largest number of resolution steps that a node can store.
const MOST_STEPS: f64 = 32_767.0;

/// A grid in source form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridSource {
    /// Positions of the nodes along X, Y, Z, mm, ascending; empty along an axis that the grid does not cover.
    pub nodes: [Vec<f64>; 3],
    /// Which of the six errors the grid states.
    pub given: [bool; 6],
    /// Errors of the nodes, mm and rad: X outermost, Z innermost.
    pub values: Vec<Twist>,
    /// Heights Z up to which the errors apply in full and from which they are zero, mm.
    pub fade_mm: Option<[f64; 2]>,
    /// Position of the other linear axes during the measurement, mm.
    pub measured_at_mm: [f64; 3],
    /// Resolution of translations (mm) and rotations (rad); the finest that 16 bits allow if not stated.
    pub resolution: [Option<f64>; 2],
}

/// The stated resolution is too fine for 16 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFine {
    /// 0 to 5: EX to EC.
    pub component: usize,
    /// Largest error, mm or rad.
    pub largest: f64,
    /// The finest resolution that can store it, mm or rad.
    pub needed: f64,
}

/// A grid, as given and as the controller reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    source: GridSource,
    header: GridHeader,
    /// Positions of free nodes, then the nodes.
    bytes: Vec<u8>,
}

impl Grid {
    /// Rounds the errors of every node to the resolution: `|stored − given| <= resolution / 2`.
    ///
    /// # Errors
    /// A stated resolution in which the largest error exceeds 32,767 steps.
    pub fn new(source: GridSource) -> Result<Grid, TooFine> {
        let mut header =
            GridHeader { fade: source.fade_mm, measured_at_mm: source.measured_at_mm, ..GridHeader::default() };
        let mut bytes = Vec::new();
        for (along, nodes) in header.axes.iter_mut().zip(&source.nodes) {
            let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { continue };
            let free = !is_equidistant(nodes);
            *along = GridAxis { nodes: u16::try_from(nodes.len()).unwrap_or(u16::MAX), ends: [*first, *last], free };
            if free {
                bytes.extend(nodes.iter().flat_map(|node| node.to_le_bytes()));
            }
        }
        for component in (0..6).filter(|component| source.given[*component]) {
            let largest = source.values.iter().fold(0.0, |most: f64, value| most.max(value[component].abs()));
            let stated = source.resolution[usize::from(component >= 3)];
            let finest = finest(largest, component);
            if stated.is_some_and(|stated| largest > stated * MOST_STEPS) {
                return Err(TooFine { component, largest, needed: finest });
            }
            header.given |= 1 << component;
            header.scales[component] = stated.unwrap_or(finest);
        }
        for value in &source.values {
            for component in (0..6).filter(|component| source.given[*component]) {
                let steps = (value[component] / header.scales[component]).round() as i16;
                bytes.extend(steps.to_le_bytes());
            }
        }
        Ok(Grid { source, header, bytes })
    }

    /// The grid of a compiled file, byte for byte, with the stored errors.
    pub fn from_data(data: &GridData<'_>) -> Grid {
        let header = *data.header();
        let nodes = std::array::from_fn(|axis| {
            (0..usize::from(header.axes[axis].nodes)).filter_map(|index| data.position(axis, index)).collect()
        });
        let source = GridSource {
            nodes,
            given: std::array::from_fn(|component| header.given >> component & 1 == 1),
            values: data.indices().filter_map(|index| data.node(index)).collect(),
            fade_mm: header.fade,
            measured_at_mm: header.measured_at_mm,
            resolution: [None; 2],
        };
        Grid { source, header, bytes: data.stored_bytes().concat() }
    }

    /// The grid as given.
    pub fn source(&self) -> &GridSource {
        &self.source
    }

    /// The header of its compiled form.
    pub fn header(&self) -> &GridHeader {
        &self.header
    }

    /// The bytes after the header.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The grid as the controller reads it.
    pub fn data(&self) -> GridData<'_> {
        match GridData::new(self.header, &self.bytes) {
            Some((data, _)) => data,
            // Nodes and values that do not match become an empty grid, which every check refuses.
            None => GridData::default(),
        }
    }

    /// Largest step of the slope of an error from one cell to the next along X (0), Y or Z: mm or rad per mm.
    pub(crate) fn slope_step(&self, axis: usize, component: usize) -> f64 {
        let GridSource { nodes, values, .. } = &self.source;
        let stride = nodes.iter().skip(axis + 1).map(|nodes| nodes.len().max(1)).product::<usize>();
        let (along, count) = (&nodes[axis], nodes[axis].len());
        let mut most = 0.0_f64;
        for middle in
            (0..values.len()).filter(|number| (1..count.max(1) - 1).contains(&(number / stride % count.max(1))))
        {
            let index = middle / stride % count;
            let [before, here, after] =
                [middle - stride, middle, middle + stride].map(|number| values[number][component]);
            let slope = |low: f64, high: f64, at: usize| (high - low) / (along[at + 1] - along[at]);
            most = most.max((slope(here, after, index) - slope(before, here, index - 1)).abs());
        }
        most
    }

    /// The grid with every error times a factor, at the finest resolution that 16 bits allow.
    pub(crate) fn scaled(&self, share: f64) -> Grid {
        let mut source = GridSource { resolution: [None; 2], ..self.source.clone() };
        source.values.iter_mut().flatten().for_each(|error| *error *= share);
        // Without a stated resolution this cannot fail.
        Grid::new(source).unwrap_or_else(|_| self.clone())
    }
}

/// Whether the nodes are equidistant within a billionth of their distance, as for tables.
fn is_equidistant(nodes: &[f64]) -> bool {
    let [first, .., last] = nodes else { return true };
    let cell = (last - first) / (nodes.len() - 1) as f64;
    nodes.iter().enumerate().all(|(index, node)| (node - first - cell * index as f64).abs() <= 1e-9 * cell)
}

/// The finest of 0.001, 0.002, 0.005, 0.01 … µm (µrad) in which 16 bits can store an error.
fn finest(largest: f64, component: usize) -> f64 {
    let unit = if component < 3 { 1e6 } else { 1e9 };
    let steps = (0..12).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power) / unit));
    steps.into_iter().find(|step| largest <= step * MOST_STEPS).unwrap_or(largest / MOST_STEPS)
}
