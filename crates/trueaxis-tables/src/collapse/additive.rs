//! The best sum of one-dimensional functions on a tensor grid.

/// One level of an axis: its position, its direction of travel, and its share of the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Position, mm.
    pub(super) position: f64,
    /// 0 in positive travel, 1 in negative travel.
    pub(super) reverse: f64,
    /// Weight; the weights of an axis add up to 1.
    pub(super) weight: f64,
}

/// Levels at the nodes of an axis, in positive travel first and, if `two_sided`, all of them again in negative travel.
///
/// Weights are those of the trapezoidal rule: sums over the levels are means over the length between the first and last node.
pub(super) fn levels(nodes: &[f64], two_sided: bool) -> Vec<Level> {
    let span = match (nodes.first(), nodes.last()) {
        (Some(first), Some(last)) if last > first => last - first,
        _ => return nodes.iter().map(|&position| Level { position, reverse: 0.0, weight: 1.0 }).collect(),
    };
    let directions: &[f64] = if two_sided { &[0.0, 1.0] } else { &[0.0] };
    let share = 0.5 / (span * directions.len() as f64);
    let at = |k: usize| nodes[k.min(nodes.len() - 1)];
    let mut levels = Vec::with_capacity(nodes.len() * directions.len());
    for &reverse in directions {
        levels.extend((0..nodes.len()).map(|k| Level {
            position: at(k),
            reverse,
            weight: share * (at(k + 1) - at(k.saturating_sub(1))),
        }));
    }
    levels
}

/// Main effects of a function d of three axes: its weighted means.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MainEffects {
    /// Mean over all levels of all axes.
    pub(super) grand: [f64; 3],
    /// Means over the levels of the two other axes, for every level of each axis.
    pub(super) marginal: [Vec<[f64; 3]>; 3],
}

impl MainEffects {
    /// `d(i, j, k) ≈ grand + Σ (marginal − grand)`, least squares over the levels with product weights.
    ///
    /// On a full tensor grid the columns of different axes are orthogonal once their means are removed, so each effect is a
    /// mean and no equations have to be solved. Cost: one evaluation of `error` for every cell of the grid.
    ///
    /// Source: analysis of variance of a balanced layout (Scheffé 1959, The Analysis of Variance, chapter 4).
    pub(super) fn of(levels: &[Vec<Level>; 3], error: impl Fn([Level; 3]) -> [f64; 3]) -> MainEffects {
        let mut effects =
            MainEffects { grand: [0.0; 3], marginal: [0, 1, 2].map(|i: usize| vec![[0.0; 3]; levels[i].len()]) };
        for (i, &x) in levels[0].iter().enumerate() {
            for (j, &y) in levels[1].iter().enumerate() {
                for (k, &z) in levels[2].iter().enumerate() {
                    let d = error([x, y, z]);
                    for c in 0..3 {
                        effects.grand[c] += x.weight * y.weight * z.weight * d[c];
                        effects.marginal[0][i][c] += y.weight * z.weight * d[c];
                        effects.marginal[1][j][c] += x.weight * z.weight * d[c];
                        effects.marginal[2][k][c] += x.weight * y.weight * d[c];
                    }
                }
            }
        }
        effects
    }

    /// The sum that approximates d at one cell of the grid.
    pub(super) fn sum(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|c| {
            self.marginal[0][i][c] + self.marginal[1][j][c] + self.marginal[2][k][c] - 2.0 * self.grand[c]
        })
    }
}
