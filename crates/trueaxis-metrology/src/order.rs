//! Sorting by a number, with code that is compiled once, not once per type of item.

use std::vec::Vec;

/// Returns the indices of the numbers in ascending order of [`f64::total_cmp`]; equal numbers keep their order. Cost: n log n.
pub fn ascending(numbers: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|one, other| numbers[*one].total_cmp(&numbers[*other]));
    order
}

/// Sorts items by a number of each, in the order of [`ascending`]. Cost: n log n, and as much memory again.
pub fn sort_by_number<T>(items: &mut Vec<T>, number: impl Fn(&T) -> f64) {
    let numbers: Vec<f64> = items.iter().map(number).collect();
    let mut before: Vec<Option<T>> = items.drain(..).map(Some).collect();
    for at in ascending(&numbers) {
        items.extend(before[at].take());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn equal_numbers_keep_their_order_and_none_is_lost() {
        let mut items = vec![(2.0, 'a'), (-0.0, 'b'), (0.0, 'c'), (2.0, 'd'), (f64::NAN, 'e'), (-1.0, 'f'), (2.0, 'g')];
        let mut known = items.clone();
        known.sort_by(|one, other| one.0.total_cmp(&other.0));
        sort_by_number(&mut items, |item| item.0);
        let letters = |items: &[(f64, char)]| items.iter().map(|item| item.1).collect::<Vec<_>>();
        assert_eq!(letters(&items), letters(&known));
        assert_eq!(letters(&items), ['f', 'b', 'c', 'a', 'd', 'g', 'e']);
    }
}
