//! The nine-term form at many positions on a host.

use super::nine::NineTerms;
use super::table::AxisTable;
use super::{Compensation, Direction, PASSES_MASK, Squareness, ThermalLine};

/// The nine-term form of three axes, looked up at the command, for many positions at once: the numbers of
/// [`Compensation::pose_error`] and [`Compensation::correction`] at each of them, bit for bit.
///
/// Not generic, so that it is compiled and optimised with this crate and not in whatever way the caller's crate is.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    tables: [AxisTable<'a, f64, f64>; 3],
    origins: [f64; 3],
    datum: [f64; 3],
    squareness: Squareness<f64>,
    is_cubic: bool,
    passes: u8,
}

impl<'a, const N: usize> Compensation<'a, f64, f64, N> {
    /// The form for many positions; `None` for the volumetric form, with grids, with periods, with rotary axes, for tables of unlike
    /// kinds or looked up at the feedback.
    #[doc(hidden)]
    pub fn batch(&self) -> Option<Batch<'a>> {
        let nine = self.nine_terms().filter(|_| self.grids().is_none() && self.periods().is_none())?;
        let is_cubic = nine.cells()?;
        let NineTerms { tables, origins, datum, squareness, .. } = nine;
        Some(Batch {
            tables: *tables.first_chunk()?,
            origins: *origins.first_chunk()?,
            datum: *datum.first_chunk()?,
            squareness: *squareness,
            is_cubic,
            passes: self.passes,
        })
    }
}

impl Batch<'_> {
    /// Writes the error at every position of X, Y, Z, mm; returns the number of positions beyond a table's end.
    pub fn errors(
        &self,
        positions: &[[f64; 3]],
        directions: &[Direction; 3],
        thermal: &[ThermalLine<f64>; 3],
        errors: &mut [[f64; 3]],
    ) -> usize {
        match self.is_cubic {
            true => self.errors_of::<true>(positions, directions, thermal, errors),
            false => self.errors_of::<false>(positions, directions, thermal, errors),
        }
    }

    /// Writes the correction at every position of X, Y, Z, mm; returns the number of positions beyond a table's end.
    pub fn corrections(
        &self,
        positions: &[[f64; 3]],
        directions: &[Direction; 3],
        thermal: &[ThermalLine<f64>; 3],
        corrections: &mut [[f64; 3]],
    ) -> usize {
        match self.is_cubic {
            true => self.corrections_of::<true>(positions, directions, thermal, corrections),
            false => self.corrections_of::<false>(positions, directions, thermal, corrections),
        }
    }

    fn errors_of<const CUBIC: bool>(
        &self,
        positions: &[[f64; 3]],
        directions: &[Direction; 3],
        thermal: &[ThermalLine<f64>; 3],
        errors: &mut [[f64; 3]],
    ) -> usize {
        let mut beyond = 0;
        for (position, result) in positions.iter().zip(errors) {
            let (error, edge) = self.error::<CUBIC>(self.coordinates(*position), directions, thermal);
            *result = error;
            beyond += usize::from(edge);
        }
        beyond
    }

    fn corrections_of<const CUBIC: bool>(
        &self,
        positions: &[[f64; 3]],
        directions: &[Direction; 3],
        thermal: &[ThermalLine<f64>; 3],
        corrections: &mut [[f64; 3]],
    ) -> usize {
        let mut beyond = 0;
        for (position, result) in positions.iter().zip(corrections) {
            let command = self.coordinates(*position);
            // The first pass is at the command.
            let (mut error, edge) = self.error::<CUBIC>(command, directions, thermal);
            for _ in 1..self.passes & PASSES_MASK {
                let ([x, y, z], [ex, ey, ez]) = (command, error);
                (error, _) = self.error::<CUBIC>([x - ex, y - ey, z - ez], directions, thermal);
            }
            *result = [-error[0], -error[1], -error[2]];
            beyond += usize::from(edge);
        }
        beyond
    }

    #[inline(always)]
    fn coordinates(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [of_x, of_y, of_z] = &self.tables;
        [of_x.coordinate(x), of_y.coordinate(y), of_z.coordinate(z)]
    }

    /// Error at table coordinates, and whether an axis is beyond its table.
    #[inline(always)]
    fn error<const CUBIC: bool>(
        &self,
        [x, y, z]: [f64; 3],
        directions: &[Direction; 3],
        thermal: &[ThermalLine<f64>; 3],
    ) -> ([f64; 3], bool) {
        let ([of_x, of_y, of_z], [reverse_x, reverse_y, reverse_z]) = (&self.tables, *directions);
        let (along_x, edge_x) = of_x.at_once::<CUBIC>(x, reverse_x);
        let (along_y, edge_y) = of_y.at_once::<CUBIC>(y, reverse_y);
        let (along_z, edge_z) = of_z.at_once::<CUBIC>(z, reverse_z);
        let mut sum = [0.0; 4];
        for k in 0..4 {
            sum[k] = along_x[k] + along_y[k] + along_z[k];
        }
        let ([ox, oy, oz], [dx, dy, dz], [grow_x, grow_y, grow_z]) = (self.origins, self.datum, thermal);
        let (qx, qy, qz) = (x + ox, y + oy, z + oz);
        let [tilt_x, tilt_y] = self.squareness.error(qy, qz);
        let error =
            [sum[0] + grow_x.at(qx - dx) + tilt_x, sum[1] + grow_y.at(qy - dy) + tilt_y, sum[2] + grow_z.at(qz - dz)];
        (error, edge_x | edge_y | edge_z)
    }
}
