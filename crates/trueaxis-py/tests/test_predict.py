"""Parts before they are cut, compared with the command line."""

import json

import numpy as np
import pandas as pd
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


DRIVE = "position_gain_per_s = 80\nvelocity_gain_per_s = 600\nreset_time_s = 0.01\nlowest_resonance_hz = 1000\n"
SMALL = 'name = "small"\nchain = "w X\' Y\' b Z t"\n[location]\nC0Y_urad = 50\n[uncertainty]\nsensor_k = 0.1\n' + "".join(
    f"[axis.{axis}]\ntravel_mm = [-100, 100]\n[axis.{axis}.uncertainty]\nscale_ppm = 10\n[axis.{axis}.thermal]\nexpansion_um_per_m_k = 10\n"
    f"[axis.{axis}.drive]\n{DRIVE}"
    for axis in "XYZ"
)
RING = """name = "ring"
program = "ring.ngc"
at_mm = [0, 0, -50]
[[feature]]
name = "bore"
kind = "circle"
lines = [3, 3]
[[tolerance]]
feature = "bore"
kind = "size"
limits_um = [-0.45, 0.45]
[probe]
repeatability_um = 0.1
[[instrument]]
kind = "ring"
diameter_mm = 40
uncertainty_um = 0.1
[[instrument]]
kind = "ball"
"""


@pytest.fixture
def small(tmp_path):
    (tmp_path / "machine.toml").write_text(SMALL)
    (tmp_path / "part.toml").write_text(RING)
    (tmp_path / "ring.ngc").write_text("G21 G90 G17 F1000\nG0 X20 Y0 Z0\nG3 X20 Y0 I-20 J0\nM2\n")
    return tmp_path


def test_temperatures_are_those_of_the_command(small):
    record = {"t_s": [36000.0, 36010.0, 36600.0], "T1_c": [24.0, 24.0, 26.0]}
    (small / "shift.csv").write_text("t_s,T1_c\n" + "".join(f"{t},{c}\n" for t, c in zip(*record.values())))
    machine, part = trueaxis.Machine.load(small), small / "part.toml"
    for option, given in ((["--at", "10:00"], {"at": "10:00"}), (["--start", "120"], {"start": 120.0})):
        call = ["predict", small, part, "--thermal", small / "shift.csv", *option, "--trials", "200", "--json"]
        code, out, err = command(*call)
        assert code == 0, err
        found = trueaxis.predict(machine, part, thermal=small / "shift.csv", trials=200, **given)
        assert found == json.loads(out)
        own = trueaxis.predict(machine, part, thermal=pd.DataFrame(record), trials=200, **given)
        assert own.features == found.features and own.temperature.sensors == found.temperature.sensors
    # 10 µm/(m K) over 4 K and the diameter.
    cold = trueaxis.predict(machine, part, trials=200).features[0].uncorrected_um
    warm = trueaxis.predict(machine, part, thermal=record, at="10:00", trials=200).features[0].uncorrected_um
    assert warm - cold == pytest.approx(10e-6 * 4 * 40e3, abs=0.02)


def test_refused_temperatures_name_what_is_needed(small):
    machine, part = trueaxis.Machine.load(small), small / "part.toml"
    record = {"t_s": [0.0, 1.0], "T1_c": [24.0, 24.0]}
    for given, text in (
        ({"start": 1.0}, "start: found no record of temperatures, needed thermal"),
        ({"at": "10:00"}, "at: found no record of temperatures, needed thermal"),
        ({"thermal": record, "start": 1.0, "at": "10:00"}, "at: found start and at, needed one of the two"),
        ({"thermal": record, "start": float("nan")}, "start: found NaN, needed a finite number"),
        ({"thermal": record, "at": "24:00"}, 'at: found "24:00", needed hours and minutes, 00:00 to 23:59'),
    ):
        assert refused(lambda: trueaxis.predict(machine, part, **given)) == text
    assert "needed rows until" in refused(lambda: trueaxis.predict(machine, part, thermal=record))
    assert "found column \"T17_c\"" in refused(lambda: trueaxis.predict(machine, part, thermal={"t_s": [0.0], "T17_c": [20.0]}))


def test_the_servo_and_the_advice_are_those_of_the_command(small):
    machine, part = trueaxis.Machine.load(small), small / "part.toml"
    code, out, err = command("predict", small, part, "--servo", "--rate-hz", "2000", "--trials", "200", "--json")
    assert code == 0, err
    found = trueaxis.predict(machine, part, servo=True, rate_hz=2000, trials=200)
    assert found == json.loads(out)
    assert list(found.to_frame()["everything on"]) == [found.features[0].everything_um]
    # The lag of a loop with 80/s shrinks the circle.
    assert found.features[0].corrected_um < -0.5 and found.servo.rate_hz == 2000
    assert "needed" in refused(lambda: trueaxis.predict(machine, part, servo=True, rate_hz=10))
    bare = small / "bare"
    bare.mkdir()
    (bare / "machine.toml").write_text(SMALL.replace(f"[axis.X.drive]\n{DRIVE}", ""))
    code, _, err = command("predict", bare, part, "--servo")
    assert code == 2 and err.strip() == f"error: {refused(lambda: trueaxis.predict(trueaxis.Machine.load(bare), part, servo=True))}"

    advised = trueaxis.predict(machine, part, trials=200, advise=True)
    measurements, after = advised.advice_measurements, advised.advice_after
    assert list(measurements.name) == [of.name for of in advised.advice.measurements] and measurements.minutes.sum() == pytest.approx(advised.advice.minutes)
    [row], [own] = after.to_dict("records"), advised.advice.features
    assert (row["before_um"], row["high_um"], row["verdict_after"]) == (own.before_um, own.interval_um.high, own.verdict_after)
    assert row["after_um"] < row["before_um"] and set(measurements.name) & {"ring", "ball"}
    with pytest.raises(ValueError, match="needed predict with advise=True"):
        found.advice_after
