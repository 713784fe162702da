"""The NumPy evaluation in speed.py, which is independent of the module, computes the same numbers."""

import sys
from pathlib import Path

import numpy as np

import trueaxis

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import speed


def test_numpy_finds_the_same_errors_and_corrections():
    machine, mill, at = trueaxis.Machine.load(speed.MACHINE), speed.Mill(speed.MACHINE), speed.positions(20_000)
    assert np.abs(machine.error(at)).max() > 10.0
    assert np.allclose(machine.error(at), 1e3 * mill.error(at), rtol=0, atol=1e-9)
    for passes in (1, 2, 3):
        found = machine.correction(at, inverse_passes=passes)
        assert np.allclose(found, mill.correction(at, passes), rtol=0, atol=1e-12)
