//! Checks the covariance in a fit's document against the standard errors that the document prints.

use serde_json::Value;

/// The number at a path such as `backlash_um.x` or `centre_um[0]`.
///
/// # Panics
/// There is none.
#[track_caller]
pub fn at(document: &Value, path: &str) -> f64 {
    let pointer = format!("/{}", path.replace(['.', '['], "/").replace(']', ""));
    document.pointer(&pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} not in {document}"))
}

/// Checks that the estimates of a covariance are the values printed, that its diagonal has the squares of their standard errors,
/// and that it is symmetric; `printed` gives value and standard error by name. Returns the names.
///
/// # Panics
/// They differ.
#[track_caller]
pub fn check(covariance: &Value, printed: impl Fn(&str) -> [f64; 2]) -> Vec<String> {
    let names: Vec<String> = serde_json::from_value(covariance["names"].clone()).unwrap();
    let entry = |i: usize, j: usize| at(covariance, &format!("matrix[{i}][{j}]"));
    for (i, name) in names.iter().enumerate() {
        let [value, error] = printed(name);
        assert!((at(covariance, &format!("estimates[{i}]")) - value).abs() <= 1e-9 * value.abs(), "{name}");
        assert!((entry(i, i).sqrt() / error - 1.0).abs() < 1e-9, "{name}: {} for {error}", entry(i, i).sqrt());
        for (j, other) in names[..i].iter().enumerate() {
            let apart = (entry(i, j) - entry(j, i)).abs();
            assert!(apart <= 1e-9 * (entry(i, i) * entry(j, j)).sqrt(), "{name}, {other}");
        }
    }
    names
}
