//! Look-ups for many positions on a host.

use super::AxisTable;
use crate::compensation::reversal::Direction;
use crate::real::Real;

impl AxisTable<'_, f64, f64> {
    /// [`AxisTable::at_cubic`] or, not `CUBIC`, [`AxisTable::at_linear`]: the same operations in the same order, written so
    /// that the four numbers are computed side by side.
    #[inline(always)]
    pub(in crate::compensation) fn at_once<const CUBIC: bool>(
        &self,
        at: f64,
        direction: Direction,
    ) -> ([f64; 4], bool) {
        let (index, t, edge) = if self.knots.is_empty() {
            let wanted = at * self.scale;
            let clamped = Real::limit(wanted, 0.0, self.last);
            let index = clamped.to_i32();
            (index as usize, clamped - f64::of_i32(index), wanted != clamped)
        } else {
            let clamped = Real::limit(at, 0.0, self.span);
            let (index, t) = self.search(clamped);
            (index, t, at != clamped)
        };
        let index = index.wrapping_add(self.reverse_offset & direction.mask());
        let mut sum = [0.0; 4];
        if CUBIC {
            let Some([value, c1, c2, c3]) = self.cubic.get(index) else { return (sum, false) };
            for k in 0..4 {
                sum[k] = value[k] + t * (c1[k] + t * (c2[k] + t * c3[k]));
            }
        } else {
            let Some([value, slope]) = self.linear.get(index) else { return (sum, false) };
            for k in 0..4 {
                sum[k] = value[k] + t * slope[k];
            }
        }
        (sum, edge)
    }
}
