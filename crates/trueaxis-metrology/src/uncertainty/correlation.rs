//! Correlation of uncertain quantities.

use nalgebra::DMatrix;
use std::vec::Vec;

/// Lowest eigenvalue of a matrix of coefficients that counts as rounding: a dozen quantities to four decimals.
const ROUNDING: f64 = -1e-3;

/// Two quantities and their coefficient.
pub type Pair = ([usize; 2], f64);

/// Correlated quantities in a list of which all others are independent.
///
/// ```text
/// z = F n                R = F Fᵀ, F = V √Λ Vᵀ of R = V Λ Vᵀ: also if R is singular       n independent, of unit variance
/// x_i = z_i √(ν/χ²)      one χ² for all of a group that have the same ν
/// ```
///
/// Quantities of a group with the same degrees of freedom were found by one fit, and its residuals gave all their standard
/// uncertainties: their distribution is the multivariate t (JCGM 102:2011, 5.3.2), with one draw of χ²_ν. Those with other
/// degrees of freedom get draws of their own, which leaves each quantity the distribution that it has alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correlations {
    groups: Vec<Group>,
    /// For every quantity the first of its group with the same degrees of freedom.
    first: Vec<usize>,
}

/// Quantities that are connected by coefficients.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    members: Vec<usize>,
    matrix: DMatrix<f64>,
    factor: DMatrix<f64>,
}

/// Coefficients that no quantities can have.
#[derive(Clone, Debug, PartialEq)]
pub struct Impossible {
    /// Place of the pair that contributes most.
    pub pair: usize,
    /// The quantities that contradict each other.
    pub members: Vec<usize>,
    /// Lowest eigenvalue of their coefficients.
    pub lowest: f64,
}

impl Correlations {
    /// Each pair once, with −1 to 1; the degrees of freedom of every quantity, infinite if it is well known.
    ///
    /// # Errors
    /// Coefficients whose matrix is not positive semidefinite.
    ///
    /// # Panics
    /// A pair beyond the quantities.
    pub fn new(pairs: &[Pair], degrees_of_freedom: &[f64]) -> Result<Correlations, Impossible> {
        let mut first: Vec<usize> = (0..degrees_of_freedom.len()).collect();
        let groups = connected(pairs, degrees_of_freedom.len()).into_iter().map(|members| {
            for (k, member) in members.iter().enumerate() {
                let alike = |own: &&usize| degrees_of_freedom[**own] == degrees_of_freedom[*member];
                first[*member] = members[..k].iter().find(alike).copied().unwrap_or(*member);
            }
            Group::new(members, pairs)
        });
        let groups = groups.collect::<Result<_, _>>()?;
        Ok(Correlations { groups, first })
    }

    /// Whether all quantities are independent.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The groups of correlated quantities.
    pub fn groups(&self) -> impl Iterator<Item = &[usize]> {
        self.groups.iter().map(|group| group.members.as_slice())
    }

    /// The quantity whose draw of χ² this one has.
    pub fn first(&self, quantity: usize) -> usize {
        self.first.get(quantity).copied().unwrap_or(quantity)
    }

    /// R d: each part plus what is common with the others.
    pub fn times(&self, d: &[f64]) -> Vec<f64> {
        self.by(d, |group| &group.matrix)
    }

    /// F n: correlated numbers from independent ones.
    pub fn mixed(&self, independent: &[f64]) -> Vec<f64> {
        self.by(independent, |group| &group.factor)
    }

    fn by(&self, of: &[f64], matrix: impl Fn(&Group) -> &DMatrix<f64>) -> Vec<f64> {
        let mut found = of.to_vec();
        for group in &self.groups {
            let matrix = matrix(group);
            for (row, member) in group.members.iter().enumerate() {
                found[*member] =
                    group.members.iter().enumerate().map(|(column, own)| matrix[(row, column)] * of[*own]).sum();
            }
        }
        found
    }
}

/// Groups of quantities that pairs connect, each in rising order.
fn connected(pairs: &[Pair], count: usize) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..count).collect();
    for ([a, b], _) in pairs {
        let [from, to] = [group[*a].max(group[*b]), group[*a].min(group[*b])];
        group.iter_mut().filter(|own| **own == from).for_each(|own| *own = to);
    }
    let members = |number: usize| (0..count).filter(|k| group[*k] == number).collect::<Vec<_>>();
    (0..count).map(members).filter(|members| members.len() > 1).collect()
}

impl Group {
    fn new(members: Vec<usize>, pairs: &[Pair]) -> Result<Group, Impossible> {
        let mut matrix = DMatrix::identity(members.len(), members.len());
        let place = |quantity: usize| members.iter().position(|own| *own == quantity);
        let own: Vec<(usize, [usize; 2], f64)> = pairs
            .iter()
            .enumerate()
            .filter_map(|(number, ([a, b], coefficient))| Some((number, [place(*a)?, place(*b)?], *coefficient)))
            .collect();
        for (_, [a, b], coefficient) in &own {
            matrix[(*a, *b)] = *coefficient;
            matrix[(*b, *a)] = *coefficient;
        }
        let eigen = matrix.clone().symmetric_eigen();
        let (worst, lowest) = eigen.eigenvalues.argmin();
        if lowest < ROUNDING {
            let along = eigen.eigenvectors.column(worst);
            let most = along.amax();
            let share = |(_, [a, b], coefficient): &(usize, [usize; 2], f64)| coefficient * along[*a] * along[*b];
            let pair = own.iter().min_by(|one, other| share(one).total_cmp(&share(other)));
            let pair = pair.map_or(0, |(number, ..)| *number);
            let takes_part = |(place, _): &(usize, &usize)| along[*place].abs() > 0.1 * most;
            let members = members.iter().enumerate().filter(takes_part).map(|(_, own)| *own).collect();
            return Err(Impossible { pair, members, lowest });
        }
        let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let mut factor = &eigen.eigenvectors * DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose();
        // Rounding of the coefficients would otherwise be in the variances.
        for mut row in factor.row_iter_mut() {
            let length = row.norm();
            row /= length;
        }
        Ok(Group { matrix: &factor * factor.transpose(), members, factor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [f64; 5] = [f64::INFINITY; 5];

    #[test]
    fn coefficients_are_those_of_the_factor_and_others_stay_independent() {
        let pairs = [([3, 1], 0.6), ([1, 4], -0.3)];
        let found = Correlations::new(&pairs, &KNOWN).unwrap();
        assert_eq!(found.groups().collect::<Vec<_>>(), [&[1, 3, 4][..]]);
        for k in 0..5 {
            let unit: Vec<f64> = (0..5).map(|own| f64::from(u8::from(own == k))).collect();
            let column = found.times(&unit);
            for (own, value) in column.iter().enumerate() {
                let of = |([a, b], _): &&Pair| [*a, *b] == [own, k] || [*b, *a] == [own, k];
                let wanted = if own == k { 1.0 } else { pairs.iter().find(of).map_or(0.0, |(_, r)| *r) };
                assert!((value - wanted).abs() < 1e-12, "{own} {k}: {value} for {wanted}");
            }
            // F Fᵀ unit, since F is symmetric.
            let twice = found.mixed(&found.mixed(&unit));
            assert!(twice.iter().zip(&column).all(|(a, b)| (a - b).abs() < 1e-12), "{twice:?} for {column:?}");
        }
    }

    #[test]
    fn singular_coefficients_make_one_number_of_two() {
        for sign in [1.0, -1.0] {
            let found = Correlations::new(&[([0, 2], sign)], &KNOWN).unwrap();
            let mixed = found.mixed(&[0.7, 5.0, -1.9, 2.0, 3.0]);
            assert!((mixed[0] - sign * mixed[2]).abs() < 1e-12 && mixed[0] != 0.0 && mixed[1] == 5.0, "{mixed:?}");
        }
        // Three that are one: rank 1.
        let one = Correlations::new(&[([0, 1], 1.0), ([1, 2], 1.0), ([0, 2], 1.0)], &KNOWN).unwrap();
        let mixed = one.mixed(&[1.0, 2.0, 3.0, 0.0, 0.0]);
        assert!((mixed[0] - mixed[1]).abs() < 1e-12 && (mixed[1] - mixed[2]).abs() < 1e-12, "{mixed:?}");
        assert!((mixed[0] - 6.0 / 3.0_f64.sqrt()).abs() < 1e-12, "{mixed:?}");
    }

    #[test]
    fn one_draw_of_chi_squared_for_equal_degrees_of_freedom_of_a_group() {
        let degrees = [8.0, 8.0, 5.0, 8.0, 8.0];
        let found = Correlations::new(&[([1, 3], 0.5), ([3, 2], 0.5)], &degrees).unwrap();
        assert_eq!([0, 1, 2, 3, 4].map(|k| found.first(k)), [0, 1, 2, 1, 4]);
    }

    #[test]
    fn a_contradiction_names_its_quantities() {
        // 0 and 2 with 0.7 each to 1 have at least −0.02 between them; 3 takes no part.
        let pairs = [([0, 1], 0.7), ([1, 2], 0.7), ([2, 3], 0.05), ([0, 2], -0.95)];
        let found = Correlations::new(&pairs, &KNOWN).unwrap_err();
        assert_eq!((found.pair, &found.members[..]), (3, &[0, 1, 2][..]));
        assert!(found.lowest < -0.4, "{}", found.lowest);
        // Rounded coefficients of a singular matrix pass, with variances of 1.
        let rounded = [([0, 1], 0.9), ([1, 2], 0.9), ([0, 2], 0.6199)];
        let found = Correlations::new(&rounded, &KNOWN).unwrap();
        assert!((found.times(&[1.0, 0.0, 0.0, 0.0, 0.0])[0] - 1.0).abs() < 1e-12);
    }
}
