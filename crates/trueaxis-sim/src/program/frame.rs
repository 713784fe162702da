//! Conversion of program to machine coordinates: work offset, rotation, G92 and tool length.

/// Active offsets, mm and degrees, X Y Z A B C.
///
/// machine = R(program + g92) + g5x + tool, where R turns X and Y about Z, as in LinuxCNC.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    pub(super) g5x: [f64; 6],
    /// Rotation of X and Y about Z, degrees.
    pub(super) rotation_deg: f64,
    pub(super) g92: [f64; 6],
    pub(super) tool: [f64; 6],
}

impl Frame {
    fn turned(&self, [x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
        if degrees == 0.0 {
            return [x, y];
        }
        let (sine, cosine) = libm::sincos(degrees.to_radians());
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    pub(super) fn to_machine(&self, program: [f64; 6]) -> [f64; 6] {
        let mut at: [f64; 6] = std::array::from_fn(|k| program[k] + self.g92[k]);
        [at[0], at[1]] = self.turned([at[0], at[1]], self.rotation_deg);
        std::array::from_fn(|k| at[k] + self.g5x[k] + self.tool[k])
    }

    pub(super) fn to_program(&self, machine: [f64; 6]) -> [f64; 6] {
        let mut at: [f64; 6] = std::array::from_fn(|k| machine[k] - self.tool[k] - self.g5x[k]);
        [at[0], at[1]] = self.turned([at[0], at[1]], -self.rotation_deg);
        std::array::from_fn(|k| at[k] - self.g92[k])
    }

    /// Converts a point X Y Z to machine coordinates.
    pub(super) fn point(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y, z, ..] = self.to_machine([x, y, z, 0.0, 0.0, 0.0]);
        [x, y, z]
    }

    /// Converts a direction to machine coordinates.
    pub(super) fn direction(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.turned([x, y], self.rotation_deg);
        [x, y, z]
    }
}
