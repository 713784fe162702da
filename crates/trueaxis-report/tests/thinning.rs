//! Long curves and fine histograms lose neither extremes nor counts.

use trueaxis_report::{Thinner, columns, decimate};

#[test]
fn a_spike_of_one_cycle_survives_at_any_length() {
    for length in [1_u32, 2, 99, 100, 101, 12_345, 1_000_000] {
        let mut thinner = Thinner::<u32, 1>::new(100);
        let spike = length / 3;
        for k in 0..length {
            thinner.add(k, [if k == spike { 7.0 } else { f64::from(k % 10) * 0.1 }]);
        }
        let items = thinner.items();
        assert!(items.contains(&spike) && items.contains(&0) && items.contains(&(length - 1)), "{length}");
        assert!(items.windows(2).all(|pair| pair[0] < pair[1]), "{length}");
        assert!(items.len() <= 202, "{length}: {}", items.len());
        if length <= 100 {
            assert_eq!(items.len(), length as usize);
        }
    }
}

#[test]
fn it_keeps_the_extremes_of_every_bucket_of_every_value() {
    let mut noise = trueaxis_testing::noise::Noise::new(1);
    let values: Vec<[f64; 2]> = (0..5000).map(|_| [(); 2].map(|()| noise.unit())).collect();
    let mut thinner = Thinner::<usize, 2>::new(40);
    values.iter().enumerate().for_each(|(k, value)| thinner.add(k, *value));
    let items = thinner.items();
    // 5000 items in at most 40 buckets: 128 each.
    for (number, bucket) in values.chunks(128).enumerate() {
        for key in 0..2 {
            for sign in [1.0, -1.0] {
                let most = bucket.iter().map(|v| sign * v[key]).fold(f64::MIN, f64::max);
                let found = items.iter().any(|&k| k / 128 == number && sign * values[k][key] == most);
                assert!(found, "bucket {number}, value {key}");
            }
        }
    }
}

#[test]
fn undefined_values_are_left_out() {
    let mut thinner = Thinner::<u32, 1>::new(4);
    [f64::NAN, 1.0, f64::INFINITY].into_iter().zip(0..).for_each(|(value, k)| thinner.add(k, [value]));
    assert_eq!(thinner.items(), [1]);
    assert!(Thinner::<u32, 1>::new(0).items().is_empty());
}

#[test]
fn a_spike_in_a_slice_survives_and_the_order_is_kept() {
    let points: Vec<[f64; 2]> =
        (0..100_000).map(|k| [f64::from(k), if k == 54_321 { 7.0 } else { f64::from(k % 10) * 0.1 }]).collect();
    let thin = decimate(&points, 500);
    assert!(thin.len() <= 1_002);
    assert!(thin.contains(&[54_321.0, 7.0]));
    assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
    assert!(thin.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    for bucket in points.chunks(200) {
        let range = bucket[0][0]..=bucket[199][0];
        let lowest = bucket.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        assert!(thin.iter().any(|point| range.contains(&point[0]) && point[1] == lowest));
    }
}

#[test]
fn short_empty_constant_and_undefined_slices() {
    assert!(decimate(&[], 10).is_empty());
    assert_eq!(decimate(&[[1.0, 2.0]], 0), [[1.0, 2.0]]);
    assert_eq!(decimate(&[[0.0, f64::NAN], [1.0, 2.0], [f64::INFINITY, 1.0]], 10), [[1.0, 2.0]]);
    let constant: Vec<[f64; 2]> = (0..1_000).map(|k| [f64::from(k), 3.0]).collect();
    let thin = decimate(&constant, 10);
    assert!(thin.len() <= 22 && thin.iter().all(|point| point[1] == 3.0));
}

#[test]
fn columns_hold_every_count_once_and_do_not_overlap() {
    // Buckets as a histogram of three significant digits has them.
    let mut buckets = Vec::new();
    let mut low = 0_u64;
    while low < 9_000_000 {
        let width = (low / 1000).max(1).next_power_of_two();
        buckets.push((low, low + width - 1, low % 7));
        low += width;
    }
    let columns = columns(buckets.iter().copied(), 24);
    assert_eq!(columns.iter().map(|column| column.2).sum::<u64>(), buckets.iter().map(|b| b.2).sum::<u64>());
    assert!(columns.iter().all(|column| column.0 < column.1 && column.2 > 0));
    assert!(columns.windows(2).all(|pair| pair[0].1 <= pair[1].0), "{columns:?}");
    assert_eq!(trueaxis_report::columns([(u64::MAX, u64::MAX, u64::MAX)], 24).len(), 1);
}
