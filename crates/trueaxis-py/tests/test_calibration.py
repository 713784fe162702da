"""Calibration, thermal growth and uncertainty, compared with the command line and with the errors in generated records."""

import json
import shutil

import numpy as np
import pytest

import probing
import trueaxis
from shared import refused
from test_command_line import TABLES, command


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    """A task with its machine, its program and a log."""
    folder = tmp_path_factory.mktemp("task")
    (folder / "mill").mkdir()
    (folder / "mill" / "machine.toml").write_text(probing.MACHINE)
    (folder / "task.toml").write_text(probing.TASK)
    (folder / "probe.log").write_text(probing.run(trueaxis.calibrate_plan(folder / "task.toml")["program_text"]))
    return folder / "task.toml"


def test_a_plan_is_that_of_the_command(task, tmp_path):
    code, out, err = command("calibrate", "plan", task, "-o", tmp_path / "probe.ngc", "--json")
    assert code == 0, err
    found = trueaxis.calibrate_plan(task).to_dict()
    assert found.pop("program_text") == (tmp_path / "probe.ngc").read_text()
    assert found == json.loads(out)
    assert found["touches"] == 81 and found["warnings"] == []
    assert {term["name"] for term in found["terms"]} >= {"squareness C0Y", "scale of X", "backlash of X"}


def test_a_calibration_is_that_of_the_command(task, tmp_path):
    log = task.with_name("probe.log")
    code, out, err = command("calibrate", "solve", task, log, "-o", tmp_path / "new", "--json")
    assert code == 0, err
    found = trueaxis.calibrate_solve(task, log)
    assert found == json.loads(out)
    assert found["location"]["C0Y_urad"] == pytest.approx(50, abs=4 * found["standard_errors"]["location"]["C0Y_urad"])
    assert found["axes"]["X"]["scale_ppm"] == pytest.approx(40, abs=4 * found["standard_errors"]["X"]["scale_ppm"])
    assert found["axes"]["X"]["backlash_um"] == pytest.approx(6, abs=1)
    files = trueaxis.calibrate_solve(task, log, files=True)["files"]
    assert set(files) >= {"machine.toml", "x.csv"}
    for name, text in files.items():
        assert text == (tmp_path / "new" / name).read_text()
    assert files["machine.toml"].startswith("# of my own hand")
    code, out, err = command("calibrate", "solve", task, log, "--force", "--dry-run", "--json")
    assert code == 0, err
    found = trueaxis.calibrate_solve(task, log, force=True)
    assert found == json.loads(out)
    assert all(of["written"] and of["why"].startswith("forced, the rule writes ") for of in found["written"])


def test_the_terms_of_a_calibration_are_correlated(task):
    """Their covariance has the standard errors that are printed, and sums of terms have the scatter that it gives."""
    found = trueaxis.calibrate_solve(task, task.with_name("probe.log"), residuals=True)
    covariance, errors = np.array(found.covariance.matrix), [term.standard_error for term in found.terms]
    assert found.covariance.names == tuple(term.name for term in found.terms)
    assert np.sqrt(np.diag(covariance)) == pytest.approx(errors, rel=1e-12)
    assert np.linalg.eigvalsh(found.correlation).min() > -1e-12 and np.abs(found.correlation).max() == 1
    assert np.abs(found.correlation - np.eye(len(errors))).max() > 0.1
    numbers = found.to_ufloats()
    assert [number.std_dev for number in numbers.values()] == pytest.approx(errors)
    assert [number.nominal_value for number in numbers.values()] == [term.value for term in found.terms]
    one, other = np.argwhere(np.abs(np.tril(found.correlation, -1)) > 0.1)[0]
    both = list(numbers.values())[one] + list(numbers.values())[other]
    assert both.std_dev == pytest.approx(np.sqrt(covariance[one, one] + covariance[other, other] + 2 * covariance[one, other]))
    # The touches' scatter is that of their residuals.
    assert found.residuals_um.shape == (81,)
    assert np.sqrt(np.sum(found.residuals_um**2) / found.degrees_of_freedom) == pytest.approx(found.sigma_um, rel=0.1)
    assert trueaxis.calibrate_solve(task, task.with_name("probe.log")).residuals_um is None
    with pytest.raises(ValueError, match="Circle: found no covariance"):
        trueaxis.circle([[1, 0], [0, 1], [-1, 0]]).to_ufloats()


def test_a_log_that_cannot_be_used_is_refused_in_the_words_of_the_command(task, tmp_path):
    lines = task.with_name("probe.log").read_text().splitlines()
    cases = {
        "missing.log": [line for line in lines if not line.startswith("touch 9 ")],
        "twice.log": [*lines, lines[8]],
        "no-trip.log": [line[:-8] + "0.000000" if line.startswith("touch 20 ") else line for line in lines],
        "other.log": ["trueaxis calibrate 00000001 touches 81", *lines[1:]],
    }
    for name, of in cases.items():
        file = tmp_path / name
        file.write_text("\n".join(of) + "\n")
        code, _, err = command("calibrate", "solve", task, file, "-o", tmp_path / "new")
        assert code == 2 and not (tmp_path / "new").exists()
        assert refused(lambda: trueaxis.calibrate_solve(task, file)) == err.strip().removeprefix("error: ")
    alone = tmp_path / "task.toml"
    shutil.copytree(task.with_name("mill"), tmp_path / "mill")
    text = probing.TASK.replace('[reference]\nartefact = "ball"\nevery = 40\n', "")
    start, ring = text.index("[[artefact]]"), text.index('[[artefact]]\nname = "ring"')
    alone.write_text(text[:start] + text[ring:])
    assert "a set-up that cannot separate" in refused(lambda: trueaxis.calibrate_plan(alone))


def warm_up():
    """A record: X grows by 12 µm/(m K) from position 0, Z by 3 µm/K; the second sensor is unrelated to the growth."""
    t = np.repeat(300.0 * np.arange(192), 2)
    x = np.tile([0.0, 250.0], 192)
    warm = 6 * np.sin(t / 7000) + 3 * np.cos(t / 2300)
    noise = np.random.default_rng(2).normal(0, 0.05, len(t))
    columns = {"t_s": t, "cycle": np.floor(t / 300 / 48), "x_mm": x, "ex_um": 0.012 * warm * x + noise, "ez_um": 3 * warm - noise}
    return columns | {"T1_c": np.round(20 + warm, 3), "T2_c": np.round(20 + 2 * np.sin(t / 1234), 3)}


def test_a_thermal_fit_is_that_of_the_command(tmp_path):
    record, file, toml = warm_up(), tmp_path / "record.csv", tmp_path / "thermal.toml"
    rows = zip(*record.values())
    file.write_text(",".join(record) + "\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows))
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    asked = ["--machine", TABLES / "mill-3axis", "--hold-out", "2", "--without", "T2"]
    code, out, err = command("thermal", "fit", file, *asked, "--json", "-o", toml)
    assert code == 0, err
    found = trueaxis.thermal_fit(record, machine=mill, hold_out=[2], without=["T2"])
    assert found == json.loads(out)
    drift, left = found["held_out_um"]
    assert drift > 15 and left < 0.3
    numbers = found.to_ufloats()
    [curve] = [curve for axis in found.axes if axis.axis == "X" for curve in axis.curves if curve.of == "T1"]
    for k, (value, error) in enumerate(zip(curve.slope, curve.slope_error)):
        number = numbers[f"X.T1.slope[{k}]"]
        assert number.nominal_value == value and number.std_dev == pytest.approx(error)
    residuals = trueaxis.thermal_fit(record, machine=mill, hold_out=[2], without=["T2"], residuals=True).residuals_um
    held_out = residuals[record["cycle"] == 2]
    assert residuals.shape == (384, 2) and np.max(np.abs(held_out)) == pytest.approx(left)
    # Two points in each of four cycles begin at zero; the noise of a difference is that of the record times the root of 2.
    assert np.sum(np.all(residuals == 0, axis=1)) == 8
    assert np.std(residuals, axis=0) == pytest.approx(0.05 * np.sqrt(2), rel=0.4)
    text = trueaxis.thermal_fit(file, machine=mill, hold_out=[2], without=["T2"], toml=True).toml
    assert text == toml.read_text()
    assert refused(lambda: trueaxis.thermal_fit(record, rate_k_per_min=0.0)) == "rate_k_per_min: found 0, needed 0.1 to 1000"
    assert "rate_k_per_min = 40" in trueaxis.thermal_fit(record, rate_k_per_min=40.0, toml=True).toml
    assert refused(lambda: trueaxis.thermal_fit(record, without=["T7"])) == "without: found T7, needed one of T1, T2"
    gap = {name: np.delete(values, [120, 121]) for name, values in record.items()}
    with pytest.warns(UserWarning, match="line 122: 2 rows of cycle 1 are missing, 600 s where rows are 300 s apart"):
        missing = trueaxis.thermal_fit(gap)["missing"]
    assert missing == [{"line": 122, "cycle": 1, "rows": 2, "found_s": 600.0, "interval_s": 300.0}]
    record["T1_c"][100] = 400.0
    assert refused(lambda: trueaxis.thermal_fit(record)).startswith("record:102: column T1_c: found 400")


def test_uncertainty_is_that_of_the_command(tmp_path):
    for name, at, more, asked in [
        ("mill-3axis", [120.0, -40.0, -200.0], ["--volume", ",-100:100,"], {"volume_mm": [None, [-100, 100], None]}),
        ("mill-5axis", None, ["--pose", "A=-30", "--points", "5"], {"pose_deg": {"A": -30.0}, "points": 5}),
    ]:
        folder = tmp_path / name
        shutil.copytree(TABLES / name, folder)
        if "[uncertainty]" not in (folder / "machine.toml").read_text():
            with open(folder / "machine.toml", "a", encoding="utf-8") as toml:
                toml.write("\n[uncertainty]\ndevice_um_per_m = 0.5\n")
        machine = trueaxis.Machine.load(folder)
        places = [] if at is None else ["--at", ",".join(map(str, at))]
        code, out, err = command("uncertainty", folder, *places, *more, "--trials", "500", "--seed", "3", "--json")
        assert code == 0, err
        found = machine.uncertainty(at=at, trials=500, seed=3, **asked)
        assert found == json.loads(out)
        assert found["worst"]["jacobian"]["radius_um"] > 0.1 and sum(term["share"] for term in found["contributions"]) == pytest.approx(1)


def test_refusals_of_uncertainty(tmp_path):
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    assert refused(lambda: mill.uncertainty(at=[1.0, 2.0])) == "at: found 2 numbers, needed three, X,Y,Z"
    assert refused(lambda: mill.uncertainty(at=[1.0, 2.0, float("nan")])).startswith("at: found NaN for axis Z")
    assert refused(lambda: mill.uncertainty(confidence=30.0)).startswith("confidence: found 30 %")
    assert refused(lambda: mill.uncertainty(pose_deg={"A": 0.0})).startswith("pose: found A")
    assert refused(lambda: mill.uncertainty(pose_deg={"Q": 0.0})).startswith('pose_deg: found "Q"')
    assert refused(lambda: mill.uncertainty(volume_mm=[None, [10, -10], None])).startswith("volume: found Y 10 to -10")
    code, _, err = command("tables", "compile", TABLES / "mill-3axis", "-o", tmp_path / "mill.tcomp")
    assert code == 0, err
    assert refused(trueaxis.Machine.load(tmp_path / "mill.tcomp").uncertainty).startswith("machine: found a compiled file")
