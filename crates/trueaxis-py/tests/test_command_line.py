"""The module's numbers equal those that the command line prints, bit for bit; both refuse the same input."""

import json
import math
import os
import pickle
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas
import polars
import pytest

import trueaxis
from shared import assert_lock_is_released, refused

ROOT = Path(__file__).resolve().parents[3]
TABLES = ROOT / "compensation-tables"
COMMAND = os.environ["TRUEAXIS_COMMAND"]
RNG = np.random.default_rng(20)


def command(*arguments):
    run = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    return run.returncode, run.stdout, run.stderr


def written(file, header, rows):
    lines = [header] + [",".join(repr(float(value)) for value in row) for row in rows]
    file.write_text("\n".join(lines) + "\n")
    return file


def printed(*arguments):
    code, out, err = command(*arguments)
    assert code == 0, err
    header, *rows = out.splitlines()
    return dict(zip(header.split(","), np.array([row.split(",") for row in rows]).T))


def columns(table, *names):
    return np.column_stack([table[name].astype(float) for name in names])


def positions(machine, count):
    middle = {"mill-3axis": (0, 0, -200), "grinder": (100, 0, 0)}.get(machine.name, (0, 0, 0))
    width = len(machine.columns)
    spread = np.array([80.0, 80.0, 80.0] + [25.0] * (width - 3))
    return RNG.uniform(-1, 1, (count, width)) * spread + np.array(list(middle) + [0.0] * (width - 3))


CASES = [
    ("mill-3axis", {}, []),
    ("mill-3axis", {"reverse": True, "temperature_c": 26.5}, ["--reverse", "--temperature-c", "26.5"]),
    ("mill-3axis", {"model": "volumetric"}, ["--model", "volumetric"]),
    ("mill-5axis", {}, []),
    ("mill-5axis", {"model": "nine"}, ["--model", "nine"]),
    ("head-5axis", {}, []),
    ("mill-turn", {"reverse": True}, ["--reverse"]),
    ("mill-3axis", {"model": "exact", "reverse": True}, ["--model", "exact", "--reverse"]),
    ("mill-3axis", {"in_order": True}, ["--in-order"]),
    ("mill-5axis", {"model": "exact", "in_order": True}, ["--model", "exact", "--in-order"]),
    ("head-5axis", {"model": "exact", "temperature_c": 24.0}, ["--model", "exact", "--temperature-c", "24"]),
]


@pytest.mark.parametrize("name, asked, options", CASES)
@pytest.mark.filterwarnings("ignore:.*beyond a table's end")
def test_error_and_correction_are_those_of_compensate(tmp_path, name, asked, options):
    machine = trueaxis.Machine.load(TABLES / name)
    at = positions(machine, 5000)
    file = written(tmp_path / "p.csv", ",".join(machine.columns), at)
    table = printed("compensate", TABLES / name, file, *options)
    error = machine.error(at, **asked)
    assert np.abs(error).max() > 1.0
    assert np.array_equal(error, columns(table, "ex_um", "ey_um", "ez_um"))
    corrected = at + machine.correction(at, **asked)
    assert np.array_equal(corrected[:, :3], columns(table, "cx_mm", "cy_mm", "cz_mm"))


@pytest.mark.parametrize("model", ["volumetric", "exact"])
@pytest.mark.parametrize("name", ["mill-5axis", "head-5axis"])
@pytest.mark.filterwarnings("ignore:.*beyond a table's end")
def test_orientation_is_that_of_compensate(tmp_path, name, model):
    machine = trueaxis.Machine.load(TABLES / name)
    at = positions(machine, 500)
    file = written(tmp_path / "p.csv", ",".join(machine.columns), at)
    table = printed("compensate", TABLES / name, file, "--model", model, "--orientation")
    error = machine.orientation_error(at, model=model)
    assert np.abs(error).max() > 1.0
    assert np.array_equal(error, columns(table, "ea_urad", "eb_urad", "ec_urad"))
    corrected = at + machine.correction(at, model=model, orientation=True)
    assert np.array_equal(corrected, columns(table, *(f"c{column}" for column in machine.columns)))
    assert np.any(corrected[:, 3:] != at[:, 3:])


def test_nine_terms_have_no_orientation():
    machine, at = trueaxis.Machine.load(TABLES / "mill-3axis"), np.array([[0.0, 0.0, -200.0]])
    needed = 'model: found nine, which has no orientation, needed "volumetric" or "exact"'
    assert refused(lambda: machine.orientation_error(at, model="nine")) == needed
    assert refused(lambda: machine.correction(at, model="nine", orientation=True)) == needed


def test_travel_in_order_matters():
    machine = trueaxis.Machine.load(TABLES / "mill-3axis")
    there = np.column_stack([np.linspace(-50, 50, 21), np.zeros(21), np.full(21, -200.0)])
    both = np.vstack([there, there[::-1]])
    back = machine.error(both, in_order=True)[21:][::-1]
    assert np.array_equal(machine.error(both, in_order=True)[:21], machine.error(there))
    # The axis reaches the turning point in positive travel.
    assert np.array_equal(back[:-1, 0], machine.error(there, reverse=True)[:-1, 0])
    assert np.all(back[:-1, 0] != machine.error(there)[:-1, 0])


def test_passes_and_compiled_tables(tmp_path):
    compiled = tmp_path / "m.tcomp"
    assert command("tables", "compile", TABLES / "mill-3axis", "-o", compiled)[0] == 0
    machine = trueaxis.Machine.load(compiled)
    at = positions(machine, 100)
    file = written(tmp_path / "p.csv", "x_mm,y_mm,z_mm", at)
    for passes in (1, 2):
        table = printed("compensate", compiled, file, "--inverse-passes", passes)
        corrected = at + machine.correction(at, inverse_passes=passes)
        assert np.array_equal(corrected, columns(table, "cx_mm", "cy_mm", "cz_mm"))


def test_a_compiled_machine_is_the_file_of_compile(tmp_path):
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    file = tmp_path / "mill.tcomp"
    code, out, err = command("tables", "compile", TABLES / "mill-3axis", "-o", file)
    assert code == 0, err
    assert mill.compile() == file.read_bytes()
    compiled = trueaxis.Machine.load(file)
    assert refused(compiled.compile) == "machine: found a compiled file, needed a machine.toml"
    assert refused(lambda: mill.compile(rate_hz=1)).startswith("rate_hz: found 1, needed 10 to 1000000")


def test_a_machine_is_pickled_with_its_files(tmp_path):
    """Without its folder, as on another computer; a machine from a compiled file too."""
    shutil.copytree(TABLES / "mill-3axis", tmp_path / "mill")
    mill = trueaxis.Machine.load(tmp_path / "mill")
    (tmp_path / "mill.tcomp").write_bytes(mill.compile())
    compiled = trueaxis.Machine.load(tmp_path / "mill.tcomp")
    texts = [pickle.dumps(machine) for machine in (mill, compiled)]
    shutil.rmtree(tmp_path / "mill")
    (tmp_path / "mill.tcomp").unlink()
    again, compiled_again = map(pickle.loads, texts)
    assert again == mill and hash(again) == hash(mill) and compiled_again == compiled and again != compiled
    assert again.columns == mill.columns and again.compile() == mill.compile()
    at = [[20.5, 10.0, -200.0]]
    assert np.array_equal(again.error(at), mill.error(at))
    assert again.uncertainty(points=3, trials=200) == mill.uncertainty(points=3, trials=200)
    shutil.copytree(TABLES / "mill-3axis", tmp_path / "mill")
    text = (tmp_path / "mill/machine.toml").read_text()
    (tmp_path / "mill/machine.toml").write_text(text.replace("backlash_um = 2.2", "backlash_um = 2.3", 1))
    assert trueaxis.Machine.load(tmp_path / "mill") != mill


def test_contour_error_is_that_of_contour(tmp_path):
    text = json.dumps({"segments": [
        {"type": "line", "start": [0, 0, 0], "end": [10, 0, 0]},
        {"type": "arc", "start": [10, 0, 0], "end": [10, 20, 0], "center": [10, 10, 0], "normal": [0, 0, 1]},
    ]})
    (tmp_path / "path.json").write_text(text)
    path = trueaxis.Path.from_json(text)
    u = np.linspace(0, 1, 200)
    line = np.column_stack([10 * u, 0 * u, 0 * u])
    turn = np.pi * (u - 0.5)
    arc = np.column_stack([10 + 10 * np.cos(turn), 10 + 10 * np.sin(turn), 0 * u])
    actual = np.concatenate([line, arc]) + RNG.normal(0, 0.01, (400, 3))
    segment = np.repeat([0.0, 1.0], 200)
    u = np.tile(u, 2)
    rows = np.column_stack([segment, u, actual])
    file = written(tmp_path / "actual.csv", "segment,u,x_mm,y_mm,z_mm", rows)
    for method in ("guarded", "bisection"):
        table = printed("contour", tmp_path / "path.json", file, "--method", method)
        found = path.contour_error(segment, u, actual, method=method)
        assert np.array_equal(found["vector_um"], columns(table, "ex_um", "ey_um", "ez_um"))
        for name in ("segment", "u", "error_um", "evaluations"):
            assert np.array_equal(found[name], table[name].astype(float)), name
        assert np.array_equal(found["bracketed"], table["bracketed"] == "true")
    # The true distance from the arc has a closed form where the foot lies well inside it.
    x, y, z = actual[250:350].T
    distance = np.hypot(np.hypot(x - 10, y - 10) - 10, z)
    assert np.allclose(found["error_um"][250:350], 1e3 * distance, rtol=0, atol=1e-6)
    # X stops on the arc.
    actual[300:, 0] = actual[300, 0]
    assert refused(lambda: path.contour_error(segment, u, actual)).startswith("actual[300, 0]: found ")


def test_circle_is_that_of_circle(tmp_path):
    angle = RNG.uniform(0, 2 * np.pi, 60)
    points = np.column_stack([3 + 10 * np.cos(angle), 10 * np.sin(angle)]) + RNG.normal(0, 0.01, (60, 2))
    file = written(tmp_path / "points.csv", "x_mm,y_mm", points)
    code, out, err = command("circle", file, "--json")
    assert code == 0, err
    assert trueaxis.circle(points) == json.loads(out)


def test_roundness_is_that_of_roundness(tmp_path):
    n, p, q = 256, 47, 167
    theta = 2 * np.pi * np.arange(3 * n) / n
    part = lambda at: 2.0 * np.cos(3 * at) + 0.5 * np.sin(7 * at)
    rx, ry = 0.3 * np.sin(2 * theta), 0.2 * np.cos(5 * theta)
    phi = 2 * np.pi / n * np.array([0, p, p + q])
    readings = np.column_stack([part(theta + a) + ry * np.cos(a) + rx * np.sin(a) for a in phi])
    file = written(tmp_path / "probes.csv", "h1_um,h2_um,h3_um", readings)
    options = ["--n", n, "--p", p, "--q", q, "--upr", 15]
    code, out, err = command("roundness", file, *options, "--json", "-o", tmp_path / "r.csv")
    assert code == 0, err
    found = trueaxis.roundness(readings, n=n, p=p, q=q, upr=15).to_dict()
    profile, x, y = (found.pop(name) for name in ("profile_um", "rx_um", "ry_um"))
    assert found == json.loads(out)
    table = np.loadtxt(tmp_path / "r.csv", delimiter=",", skiprows=1)
    assert np.array_equal(np.column_stack([profile.ravel(), x.ravel(), y.ravel()]), table[:, 1:])
    # The profile equals the part from which the test computed the readings.
    assert profile.shape == (3, n)
    assert np.allclose(profile, part(theta).reshape(3, n), rtol=0, atol=1e-9)


def test_roundness_by_five_probes_is_that_of_roundness(tmp_path):
    n, degrees = 256, [0, 39.2, 101.3, 158.9, 243.3]
    theta = 2 * np.pi * np.arange(2 * n) / n
    phi = np.deg2rad(degrees)
    part = lambda at: 2.0 * np.cos(3 * at) + 0.5 * np.sin(7 * at)
    readings = part(theta[:, None] + phi) + 40.0 * np.cos(theta[:, None] - phi) + RNG.normal(0, 0.01, (2 * n, 5))
    readings[:, 3] += 0.2 * np.sin(0.9 * np.arange(2 * n))
    file = written(tmp_path / "probes.csv", "h1_um,h2_um,h3_um,h4_um,h5_um", readings)
    angles = ",".join(map(str, degrees))
    code, out, err = command("roundness", file, "--n", n, "--angles-deg", angles, "--json", "-o", tmp_path / "r.csv")
    assert code == 0, err
    found = trueaxis.roundness(readings, n=n, angles_deg=degrees)
    assert found.agreement.disagreeing == 4 and found.agreement.probes[3].residual_um > 0.05
    found = found.to_dict()
    for name in ("profile_um", "rx_um", "ry_um"):
        found.pop(name)
    assert found == json.loads(out)
    message = refused(lambda: trueaxis.roundness(readings[:, :4], n=n, angles_deg=degrees))
    assert message == "readings: found 4 columns, needed 5, one for each angle"
    assert "harmonics 3, 5" in refused(lambda: trueaxis.roundness(readings[:, :4], n=n, angles_deg=[0, 90, 180, 270]))


def test_roundness_of_readings_with_angles_is_that_of_roundness(tmp_path):
    n, p, q = 256, 47, 167
    theta_deg = 100.0 + 3 * 360.0 * (np.arange(4000) + RNG.uniform(0, 0.7, 4000)) / 4000
    theta = np.deg2rad(theta_deg)
    part = lambda at: 2.0 * np.cos(3 * at) + 0.5 * np.sin(7 * at)
    readings = np.column_stack([part(theta + 2 * np.pi / n * slot) for slot in (0, p, p + q)])
    file = written(tmp_path / "probes.csv", "h1_um,h2_um,h3_um,theta_deg", np.column_stack([readings, theta_deg]))
    code, out, err = command("roundness", file, "--n", n, "--p", p, "--q", q, "--json", "-o", tmp_path / "r.csv")
    assert code == 0, err
    found = trueaxis.roundness(readings, n=n, p=p, q=q, theta_deg=theta_deg).to_dict()
    profile, x, y = (found.pop(name) for name in ("profile_um", "rx_um", "ry_um"))
    assert found == json.loads(out) and found["resampling"]["rows"] == 4000
    table = np.loadtxt(tmp_path / "r.csv", delimiter=",", skiprows=1)
    assert np.array_equal(np.column_stack([profile.ravel(), x.ravel(), y.ravel()]), table[:, 1:])
    assert np.allclose(profile[1], part(2 * np.pi * np.arange(n) / n), rtol=0, atol=1e-3)
    theta_deg[7] = theta_deg[6]
    message = refused(lambda: trueaxis.roundness(readings, n=n, p=p, q=q, theta_deg=theta_deg))
    assert message.startswith("theta_deg[7]: found ") and "of the row before by" in message


def test_probe_angles_are_those_of_probe_angles():
    code, out, err = command("probe-angles", "--n", 128, "--phi2-deg", 90, "--phi3-deg", 181.05, "--count", 5, "--json")
    assert code == 0, err
    assert trueaxis.probe_angles(n=128, phi2_deg=90.0, phi3_deg=181.05, count=5) == json.loads(out)


DAMAGES = [
    ("x.csv", lambda text: text.replace("14.551", "two", 1)),
    ("x.csv", lambda text: text.replace("14.551", "nan", 1)),
    ("x.csv", lambda text: text.replace("14.551", "1e300", 1)),
    ("x.csv", lambda text: text.rstrip().rsplit(",", 1)[0]),
    ("x.csv", lambda text: "<html></html>\n"),
    ("x.csv", lambda text: ""),
    ("machine.toml", lambda text: text.replace("[axis.X]", "[axis.X", 1)),
    ("machine.toml", lambda text: text + "\n[nonsense]\nkey = 1\n"),
    ("machine.toml", None),
]


@pytest.mark.parametrize("file, damage", DAMAGES)
def test_damaged_machines_are_refused_in_the_words_of_the_command_line(tmp_path, file, damage):
    folder = tmp_path / "mill"
    shutil.copytree(TABLES / "mill-3axis", folder)
    if damage is None:
        (folder / file).unlink()
    else:
        before = (folder / file).read_text()
        (folder / file).write_text(damage(before))
        assert (folder / file).read_text() != before
    code, out, err = command("tables", "check", folder)
    assert code == 2
    assert refused(lambda: trueaxis.Machine.load(folder), FileNotFoundError if damage is None else trueaxis.Error) in err


def test_damaged_compiled_files_are_refused_in_the_words_of_the_command_line(tmp_path):
    compiled = tmp_path / "m.tcomp"
    assert command("tables", "compile", TABLES / "mill-3axis", "-o", compiled)[0] == 0
    whole = compiled.read_bytes()
    middle = len(whole) // 2
    for damaged in (whole[:-1], whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :], b"", b"\0" * 500):
        compiled.write_bytes(damaged)
        code, out, err = command("tables", "show", compiled)
        assert code == 2
        assert refused(lambda: trueaxis.Machine.load(compiled)) in err


def test_wrong_arrays_are_named():
    machine = trueaxis.Machine.load(TABLES / "mill-3axis")
    good = np.array([[0.0, 0.0, -200.0]] * 3)
    needed = "needed an array of real numbers, shape (n, 3), n at least 1"
    for of in (machine.error, machine.correction):
        for wrong, found in [
            (good.astype(complex), "dtype complex128"),
            (good.astype(object), "dtype object"),
            (good.astype(bool), "dtype bool"),
            ([["0", "0", "-200"]], "dtype <U4"),
            ("positions.csv", "str"),
            (None, "NoneType"),
        ]:
            assert refused(lambda: of(wrong), TypeError) == f"positions: found {found}, {needed}"
        assert refused(lambda: of([[0, 0], [0, 0, -200]])).startswith("positions: found setting an array element")
        assert refused(lambda: of(good[:, :2])) == f"positions: found shape (3, 2), {needed}"
        assert refused(lambda: of(good[0])) == f"positions: found shape (3,), {needed}"
        assert refused(lambda: of(good[:0])) == f"positions: found shape (0, 3), {needed}"
        for bad in (math.nan, math.inf, 1e10):
            wrong = good.copy()
            wrong[2, 1] = bad
            assert refused(lambda: of(wrong)).startswith("positions[2, 1]: found ")
        wrong[2, 1] = 900.0
        assert "positions[2, 1]: found 900, needed the declared travel, " in refused(lambda: of(wrong))
        assert refused(lambda: of(good, model="twist")).startswith('model: found "twist", needed')
        assert refused(lambda: of(good, reverse=True, in_order=True)).startswith("reverse: found in_order too")
        assert "found 1e300 K above" in refused(lambda: of(good, temperature_c=1e300)).replace("1" + "0" * 300, "1e300")
    assert refused(lambda: machine.correction(good, inverse_passes=9)) == "inverse_passes: found 9, needed 1 to 8"
    assert "straight line" in refused(lambda: trueaxis.circle(np.array([[0.0, 0], [1, 1], [2, 2]])))
    assert "whole revolutions of 64 rows" in refused(lambda: trueaxis.roundness(good, n=64, p=5, q=20))
    assert refused(lambda: trueaxis.probe_angles(n=100)) == "--n: found 100, needed a power of two from 64 to 4096"
    assert "segments: found none" in refused(lambda: trueaxis.Path.from_json('{"segments":[]}'))


def test_array_likes_are_taken_and_data_frames_by_the_names_of_their_columns():
    machine = trueaxis.Machine.load(TABLES / "mill-turn")
    at = np.round(positions(machine, 20))
    expected = machine.error(at)
    for alike in (at.tolist(), tuple(map(tuple, at)), at.astype(int), at.astype(np.float32), at.astype(">f8"), pandas.DataFrame(at, columns=machine.columns).to_numpy()):
        assert np.array_equal(machine.error(alike), expected)
    shuffled = pandas.DataFrame(at, columns=machine.columns).assign(part=1).iloc[:, ::-1]
    assert np.array_equal(machine.error(shuffled), expected)
    assert np.array_equal(machine.error(polars.DataFrame({name: shuffled[name].to_numpy() for name in shuffled})), expected)
    linear = shuffled[["z_mm", "y_mm", "x_mm"]]
    assert np.array_equal(machine.error(linear), machine.error(at[:, :3].copy()))
    found = refused(lambda: machine.error(linear.rename(columns={"z_mm": "Z"})))
    assert found == f"positions: found columns Z, y_mm, x_mm, needed x_mm, y_mm, z_mm or {', '.join(machine.columns)}"
    text = refused(lambda: machine.error(linear.assign(y_mm="0")), TypeError)
    assert text.startswith("positions: found dtype ")


def test_missing_files_are_file_not_found_errors(tmp_path):
    for call in (
        lambda: trueaxis.Machine.load(tmp_path / "nowhere"),
        lambda: trueaxis.Machine.load(tmp_path / "nowhere.tcomp"),
        lambda: trueaxis.Path.load(tmp_path / "nowhere.json"),
        lambda: trueaxis.Program.load(tmp_path / "nowhere.ngc"),
        lambda: trueaxis.calibrate_plan(tmp_path / "nowhere.toml"),
        lambda: trueaxis.keep_history(tmp_path / "nowhere.toml"),
        lambda: trueaxis.thermal_fit(tmp_path / "nowhere.csv"),
    ):
        assert "nowhere" in refused(call, FileNotFoundError)
    # A table that a machine names and that is not there is refused by the line that names it.
    (tmp_path / "machine.toml").write_text((TABLES / "mill-3axis/machine.toml").read_text())
    assert "but no file at" in refused(lambda: trueaxis.Machine.load(tmp_path))


def test_views_and_orders_of_memory_do_not_matter():
    machine = trueaxis.Machine.load(TABLES / "mill-3axis")
    at = positions(machine, 50)
    expected = machine.error(at)
    assert np.array_equal(machine.error(np.asfortranarray(at)), expected)
    assert np.array_equal(machine.error(np.repeat(at, 2, axis=0)[::2]), expected)
    assert np.array_equal(machine.error(at[::-1]), expected[::-1])


def test_clamped_positions_are_reported():
    machine = trueaxis.Machine.load(TABLES / "mill-turn")
    at = np.zeros((3, len(machine.columns)))
    assert machine.correction(at).shape == at.shape
    assert np.array_equal(machine.error(at), machine.error(at[:, :3].copy()))


def test_the_lock_is_released():
    machine = trueaxis.Machine.load(TABLES / "mill-3axis")
    at = positions(machine, 2_000_000)

    def work():
        for _ in range(3):
            machine.correction(at)

    assert_lock_is_released(work)
