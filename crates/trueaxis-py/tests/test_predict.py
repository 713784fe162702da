"""Parts before they are cut, compared with the command line."""

import json

import numpy as np
import pytest

import trueaxis
from shared import refused
from test_command_line import TABLES, command

MILL = TABLES / "mill-3axis"
PLATE = TABLES.parent / "records/plate/part.toml"


@pytest.fixture(scope="module")
def plate():
    return trueaxis.predict(trueaxis.Machine.load(MILL), PLATE, trials=200, seed=3)


def test_a_part_is_that_of_the_command(plate):
    code, out, err = command("predict", MILL, PLATE, "--trials", "200", "--seed", "3", "--json")
    assert code == 0, err
    assert type(plate) is trueaxis.PredictedPart and plate == json.loads(out)
    code, out, err = command("predict", MILL, PLATE, "--trials", "200", "--seed", "3")
    assert code == 0 and repr(plate) == out.rstrip("\n")


def test_verdicts_and_budget_are_data_frames(plate):
    frame = plate.to_frame()
    assert list(frame.index) == [f"{of.feature}, {of.kind}{' from ' if of.kind == 'distance' else ' to ' if len(of.datums) else ''}{', '.join(of.datums)}" for of in plate.features]
    assert list(frame.verdict) == [of.verdict for of in plate.features]
    assert np.array_equal(frame.corrected, [of.corrected_um for of in plate.features])
    budget = plate.budget
    own = budget[(budget.feature == "bore") & (budget.kind == "position")]
    assert own.share.sum() == pytest.approx(1.0) and own.share.is_monotonic_decreasing and own.datums.unique() == ["top, front, left"]
    assert len(budget) == sum(len(of.budget) for of in plate.features)
    html = plate._repr_html_()
    assert html.count("<table>") == 2 and "undecided" in html


def test_a_part_elsewhere_and_advice(tmp_path):
    text = PLATE.read_text().replace("at_mm = [90.0, -60.0, -250.0]", "at_mm = [20.0, -60.0, -250.0]")
    (tmp_path / "part.toml").write_text(text.partition('[[instrument]]\nkind = "ballbar"')[0])
    program = PLATE.with_name("plate.ngc")
    mill = trueaxis.Machine.load(MILL)
    code, out, err = command("predict", MILL, tmp_path / "part.toml", "--program", program, "--trials", "200", "--advise", "--json")
    assert code == 0, err
    found = trueaxis.predict(mill, tmp_path / "part.toml", program, trials=200, advise=True)
    assert found == json.loads(out) and found.advice.features[0].feature == "top"
    moved = trueaxis.predict(mill, PLATE, trials=200, at_mm=[20.0, -60.0, -250.0])
    assert moved.at_mm.tolist() == [20.0, -60.0, -250.0] and moved.features == found.features and moved.advice is None


def test_refusals_are_those_of_the_command(tmp_path):
    mill = trueaxis.Machine.load(MILL)
    for old, new in (("lines = [29, 29]", "lines = [31, 31]"), ("width_um = 3\n", "width_um = -3\n"), ("at_mm = [90.0", "at_mm = [290.0")):
        (tmp_path / "part.toml").write_text(PLATE.read_text().replace(old, new))
        (tmp_path / "plate.ngc").write_bytes(PLATE.with_name("plate.ngc").read_bytes())
        with pytest.raises(ValueError) as error:
            trueaxis.predict(mill, tmp_path / "part.toml")
        code, _, err = command("predict", MILL, tmp_path / "part.toml")
        assert code == 2 and err.strip() == f"error: {error.value}"
    assert refused(lambda: trueaxis.predict(mill, PLATE, trials=10)) == "trials: found 10, needed 200 to 1000000"
    assert refused(lambda: trueaxis.predict(mill, PLATE, at_mm=[float("nan"), 0, 0])) == "at_mm: found NaN, needed a finite number"
    with pytest.raises(FileNotFoundError):
        trueaxis.predict(mill, tmp_path / "none.toml")
