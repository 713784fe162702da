"""The NumPy evaluation in speed.py, which is independent of the module, computes the same numbers; so does every path of the
module, bit for bit."""

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


def test_many_positions_have_the_bits_of_positions_in_order_of_travel():
    """In order of travel the module looks up one position after the other, as the step does."""
    machine, at = trueaxis.Machine.load(speed.MACHINE), speed.positions(20_000)
    for turn, reverse in ((1, False), (-1, True)):
        run = np.sort(at, axis=0)[::turn]
        for temperature in (None, 23.5):
            given = {"temperature_c": temperature}
            for of in (machine.error, machine.correction):
                # The first row of a run in negative travel still counts as positive.
                found, one_by_one = of(run, reverse=reverse, **given)[1:], of(run, in_order=True, **given)[1:]
                assert np.abs(found).max() > 0.0
                assert (found.view(np.int64) == one_by_one.view(np.int64)).all()


def test_memory_of_the_caller_is_read_in_any_layout_and_kept():
    machine, at = trueaxis.Machine.load(speed.MACHINE), speed.positions(5_000).round(2)
    before = at.copy()
    wide = np.zeros((10_000, 6))
    wide[::2, ::2] = at
    locked = at.copy()
    locked.flags.writeable = False
    found = machine.error(at), machine.correction(at)
    for same in (np.asfortranarray(at), wide[::2, ::2], locked, at.tolist()):
        assert (machine.error(same) == found[0]).all() and (machine.correction(same) == found[1]).all()
    assert (at == before).all()
    single = at.astype(np.float32)
    assert (machine.error(single) == machine.error(single.astype(float))).all()
