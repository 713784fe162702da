//! Compares the covariance that a fit states with the scatter of its values over repeated records.

/// Admitted distance from the sampling error of the repeats, in its standard deviations.
const ADMITTED: f64 = 4.5;

/// Values of a fit over repeats of a record with independent noise, and the covariances stated with them.
#[derive(Clone, Debug, Default)]
pub struct Scatter {
    values: Vec<Vec<f64>>,
    stated: Vec<Vec<f64>>,
}

impl Scatter {
    /// Adds a repeat.
    pub fn add(&mut self, values: &[f64], covariance: &[Vec<f64>]) {
        if self.stated.is_empty() {
            self.stated = vec![vec![0.0; values.len()]; values.len()];
        }
        self.values.push(values.to_vec());
        for (sums, row) in self.stated.iter_mut().zip(covariance) {
            sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry);
        }
    }

    /// Checks standard deviations and correlations within the sampling error of the repeats: standard deviations within 1/√(2n)
    /// of their value and within `share` of it, Fisher's z of correlations within 1/√(n − 3) and within `share`. Returns the
    /// largest correlation stated.
    ///
    /// # Panics
    /// A standard deviation or a correlation beyond that.
    #[track_caller]
    pub fn check(&self, names: &[String], share: f64) -> f64 {
        let count = self.values.len() as f64;
        let size = self.stated.len();
        let stated = |i: usize, j: usize| self.stated[i][j] / count;
        let mean = |i: usize| self.values.iter().map(|row| row[i]).sum::<f64>() / count;
        let means: Vec<f64> = (0..size).map(mean).collect();
        let scatter = |i: usize, j: usize| {
            let products = self.values.iter().map(|row| (row[i] - means[i]) * (row[j] - means[j]));
            products.sum::<f64>() / (count - 1.0)
        };
        let correlation = |of: &dyn Fn(usize, usize) -> f64, i, j| of(i, j) / (of(i, i) * of(j, j)).sqrt();
        let mut largest: f64 = 0.0;
        for i in 0..size {
            let ratio = (scatter(i, i) / stated(i, i)).sqrt();
            let admitted = share + ADMITTED / (2.0 * count).sqrt();
            assert!((ratio - 1.0).abs() < admitted, "{}: scatter of {ratio} standard errors", names[i]);
            for j in 0..i {
                let [found, is] = [correlation(&stated, i, j), correlation(&scatter, i, j)];
                let apart = (is.atanh() - found.atanh()).abs();
                let admitted = share + ADMITTED / (count - 3.0).sqrt();
                assert!(apart < admitted, "{}, {}: correlation {found}, scatter {is}", names[i], names[j]);
                largest = largest.max(found.abs());
            }
        }
        largest
    }
}

/// A number with a normal distribution of unit variance, by Box and Muller.
pub fn normal(noise: &mut crate::noise::Noise) -> f64 {
    let radius = (-2.0 * (1.0 - noise.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * noise.unit()).cos()
}
