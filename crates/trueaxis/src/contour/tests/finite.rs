//! No query makes the search fail.

use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(20_000) as u32, ..ProptestConfig::default() })]

    /// No point, reference or state that floats can represent causes a panic or a result that is not finite.
    #[test]
    fn any_query_is_answered_with_finite_numbers(
        points in prop::collection::vec((-1e9..1e9f64, -1e9..1e9f64, -100.0..100.0f64, any::<u32>(), any::<f64>()), 6),
        near in any::<bool>(),
    ) {
        let spline = Spline::butterfly();
        let all = spans::<f64, f64>(&[spline.segment()]);
        let path = Path::new(&all, 5, near);
        let search = search(Method::Guarded);
        let mut state = ContourState::default();
        for (x, y, z, span, t) in points {
            let p = if near { [x * 1e-7, y * 1e-7, z] } else { [x, y, z] };
            let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 };
            let r = search.update(&mut state, &path, Reference { span: 5 + span % 60, t }, p);
            let all = [r.error, r.normal, r.binormal, r.tangential, r.lag, r.width, r.t, r.vector[0], r.vector[1], r.vector[2]];
            prop_assert!(all.iter().all(|x| x.is_finite()), "{r:?}");
        }
    }
}
