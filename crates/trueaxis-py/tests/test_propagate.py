"""The uncertainty of one's own data, carried through an evaluation."""

import numpy as np
import pandas as pd
import pytest

import trueaxis


def test_a_linear_evaluation_has_the_covariance_of_its_formula():
    data, u = np.array([1.0, 2.0, 4.0]), np.array([0.1, 0.2, 0.0])
    found = trueaxis.propagate(lambda x: {"sum": x.sum(), "difference": x[0] - x[1]}, data, u, draws=20_000)
    # J diag(u²) Jᵀ
    assert np.allclose(found.covariance, [[0.05, -0.03], [-0.03, 0.05]], atol=2e-3)
    assert found["sum"].value == 7.0 and abs(found["sum"].u - np.sqrt(0.05)) < 5e-3
    assert abs(found.correlation[0, 1] + 0.6) < 0.02
    numbers = found.to_ufloats()
    assert abs((numbers["sum"] + numbers["difference"]).std_dev - 2 * 0.1) < 5e-3


def test_noise_of_a_ballbar_gives_the_uncertainty_that_its_fit_states():
    degrees = np.tile(np.arange(0.5, 360, 1), 2)
    frame = pd.DataFrame({
        "angle_deg": degrees,
        "deviation_um": -2.0 * np.sin(2 * np.radians(degrees)),
        "direction": np.repeat([1, -1], 360),
    })
    frame.deviation_um += np.random.default_rng(3).normal(0, 0.05, len(frame))

    def squareness(record):
        return trueaxis.ballbar(record, radius_mm=100).figures["squareness C0Y"]

    found = trueaxis.propagate(squareness, frame, {"deviation_um": 0.05}, draws=100)
    stated = squareness(frame)
    assert found["squareness C0Y"].value == stated.value and found["squareness C0Y"].unit == stated.unit
    assert 0.75 < found["squareness C0Y"].u / stated.u < 1.35


def test_the_same_seed_gives_the_same_figures():
    def found(seed):
        return trueaxis.propagate(np.mean, [1.0, 2.0], 0.1, draws=100, seed=seed)["value"].expanded

    assert found(1) == found(1) != found(2)


@pytest.mark.parametrize(
    ("draws", "u", "message"),
    [(99, 0.1, "draws: found 99, needed at least 100"), (100, -0.1, "u: found a negative"), (100, np.nan, "u: found a negative")],
)
def test_bad_input_is_refused(draws, u, message):
    with pytest.raises(ValueError, match=message):
        trueaxis.propagate(np.mean, [1.0, 2.0], u, draws=draws)


def test_figures_must_not_change_from_draw_to_draw():
    calls = iter(range(1000))
    with pytest.raises(ValueError, match="needed 0 in every draw"):
        trueaxis.propagate(lambda _: {str(next(calls)): 1.0}, [1.0], 0.1)
