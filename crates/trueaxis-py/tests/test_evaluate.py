"""Tests with instruments, compared with the command line and with the errors in the generated records."""

import io
import json
import types

import numpy as np
import pandas
import pytest

import trueaxis
from shared import refused
from test_command_line import TABLES, command

NOISE = np.random.default_rng(7)


def same_as_command(tmp_path, kind, record, call, *options):
    """Asserts that arrays, a file and the command line produce the same document; returns it."""
    file = tmp_path / f"{kind}.csv"
    rows = zip(*record.values())
    file.write_text(",".join(record) + "\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows))
    code, out, err = command("evaluate", kind, file, "--json", *options)
    assert code == 0, err
    found = call(record)
    assert found == call(str(file)) == json.loads(out)
    with file.open() as text, file.open("rb") as binary:
        assert found == call(text) == call(binary)
    return found


def columns(names, rows):
    return dict(zip(names.split(","), np.ascontiguousarray(np.array(rows, float).T)))


def diagonals():
    """A record of a machine with C0Y = 50 µrad."""
    rows = []
    for k, (sx, sy, sz) in enumerate([(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)]):
        for direction in (1, -1):
            for step in range(6)[::direction]:
                x, y, z = 60 * sx * step, 40 * sy * step, 20 * sz * step
                rows.append([k + 1, direction, x, y, z, -1e3 * 50e-6 * y * 300 * sx / np.sqrt(14e4) + NOISE.normal(0, 0.01)])
    return columns("diagonal,direction,x_mm,y_mm,z_mm,deviation_um", rows)


def test_diagonals(tmp_path):
    call = lambda record: trueaxis.evaluate_step_diagonal(record, alignment_urad=20)
    found = same_as_command(tmp_path, "step-diagonal", diagonals(), call, "--alignment-urad", "20")
    assert found["c0y_urad"]["value"] == pytest.approx(50, abs=0.2)
    mill = TABLES / "mill-3axis"
    machine = trueaxis.Machine.load(mill)
    code, out, err = command("evaluate", "step-diagonal", tmp_path / "step-diagonal.csv", "--machine", mill, "--json", "--dry-run")
    assert code == 0, err
    decided = trueaxis.evaluate_step_diagonal(tmp_path / "step-diagonal.csv", machine=machine)["written"]
    assert decided == json.loads(out)["written"] and "C0Y_urad" in {of["key"].split(".")[-1] for of in decided}


def test_points_of_a_mill(tmp_path):
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    grid = np.meshgrid(np.linspace(-280, 280, 5), np.linspace(-180, 180, 5), np.linspace(-380, -20, 5), indexing="ij")
    at = np.ascontiguousarray(np.stack([axis.ravel() for axis in grid], axis=1))
    actual = at + 1e-3 * mill.error(at, model="exact")
    record = dict(zip(("x_mm", "y_mm", "z_mm"), at.T.copy())) | dict(zip(("actual_x_mm", "actual_y_mm", "actual_z_mm"), actual.T.copy()))
    call = lambda record: trueaxis.evaluate_points(record, machine=mill, without=["EAZ"])
    found = same_as_command(tmp_path, "points", record, call, "--machine", TABLES / "mill-3axis", "--without", "EAZ")
    assert found["before"]["max_um"] > 10 > 20 * found["left"]["rms_um"]
    noisy = record | {name: record[name] + NOISE.normal(0, 1e-3, len(at)) for name in ("actual_x_mm", "actual_y_mm", "actual_z_mm")}
    fitted = trueaxis.evaluate_points(noisy, machine=mill, without=["EAZ"], residuals=True)
    errors = [fitted.squareness.a0z_urad["standard_error"], fitted.squareness.b0z_urad["standard_error"], fitted.squareness.c0y_urad["standard_error"]]
    assert [number.std_dev for number in fitted.to_ufloats().values()] == pytest.approx(errors) and fitted.correlation.shape == (3, 3)
    assert np.sqrt(np.mean(np.sum(fitted.residuals_um**2, axis=1))) == pytest.approx(fitted.left.rms_um)
    assert refused(lambda: trueaxis.evaluate_points(record, machine=mill, nodes=[1, 5, 5])).startswith("nodes: found [1, 5, 5]")


def plate(scale_ppm, seed):
    """A lattice of 9 by 7 with a scale of X, noise of 1 µm."""
    noise = np.random.default_rng(seed)
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-160, 160, 9), np.linspace(-120, 120, 7)))
    at = np.zeros((3, x.size))
    at[:2] = x, y
    actual = at.copy()
    actual[0] += 1e-6 * scale_ppm * x
    actual[:2] += noise.normal(0, 1e-3, (2, x.size))
    return dict(zip(("x_mm", "y_mm", "z_mm"), at)) | dict(zip(("actual_x_mm", "actual_y_mm", "actual_z_mm"), actual))


def test_points_of_a_plate(tmp_path):
    record, second, other = plate(40, 1), plate(40, 2), plate(-40, 3)
    file = tmp_path / "second.csv"
    file.write_text(",".join(second) + "\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in zip(*second.values())))
    found = same_as_command(tmp_path, "points", record, lambda record: trueaxis.evaluate_points(record, against=str(file)), "--against", file)
    assert found.shape == "plane" and found.model == "affine" and found.transfer.transfers
    assert found.terms[0].name == "scale X" and found.terms[0].value == pytest.approx(40, abs=4 * found.terms[0].standard_error)
    assert not trueaxis.evaluate_points(record, against=other).transfer.transfers
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    fitted = trueaxis.evaluate_points(record, machine=mill, residuals=True)
    assert fitted.residuals_um.shape == (63, 2)
    assert np.sqrt(np.mean(np.sum(fitted.residuals_um**2, axis=1))) == pytest.approx(fitted.left.rms_um)
    line = {name: values[:9] for name, values in record.items()}
    assert trueaxis.evaluate_points(line).shape == "line"
    volume = {name: np.concatenate([values, values + (100 if "z" in name else 0)]) for name, values in record.items()}
    assert refused(lambda: trueaxis.evaluate_points(volume)).startswith("machine: found none, needed one")
    assert refused(lambda: trueaxis.evaluate_points(volume, machine=mill, against=second)).startswith("against: found points along X, Y and Z")


def test_location_errors_of_rotary_axes(tmp_path):
    rows = []
    for a in np.radians([-90, -60, -30, 0, 20]):
        for k in range(8):
            c = np.pi / 4 * k
            x, y = 60 * np.cos(c) + 20 * np.sin(c), 20 * np.cos(c) - 60 * np.sin(c)
            y, z = y * np.cos(a) + 80 * np.sin(a), 80 * np.cos(a) - y * np.sin(a)
            rows.append([x, y, z, np.degrees(a), 45 * k, *NOISE.normal(0, 0.5, 3)])
    record = columns("x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um", rows)
    five = trueaxis.Machine.load(TABLES / "mill-5axis")
    call = lambda record: trueaxis.evaluate_r_test(record, machine=five, without=["EX0C"])
    options = ["--machine", TABLES / "mill-5axis", "--without", "EX0C", "--dry-run"]
    found = same_as_command(tmp_path, "r-test", record, call, *options)
    assert found["written"]
    assert {term["name"] for term in found["terms"]} >= {"EY0C", "EY0A"}
    fitted = trueaxis.evaluate_r_test(record, machine=five, without=["EX0C"], residuals=True)
    assert np.sqrt(np.diag(fitted.covariance.matrix)) == pytest.approx([term.standard_error for term in fitted.terms])
    assert fitted.residuals_um.shape == (40, 3) and fitted.to_ufloats()["EY0A"].nominal_value == fitted.terms[fitted.covariance.names.index("EY0A")].value
    assert np.sqrt(np.mean(np.sum(fitted.residuals_um**2, axis=1))) == pytest.approx(fitted.left_rms_um)
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    assert refused(lambda: trueaxis.evaluate_r_test(record, machine=mill)).startswith("record:2: column a_deg: found an angle")


def test_drift(tmp_path):
    t = np.arange(121.0)
    record = {"t_s": 60 * t, "x1_um": 0.05 * t, "z_um": 0.2 * t, "x2_um": 0.07 * t, "ambient_c": 20 + 0.01 * t}
    call = lambda record: trueaxis.evaluate_thermal(record, test="etve", period_min=30, distance_mm=100)
    same_as_command(tmp_path, "thermal", record, call, "--test", "etve", "--period-min", "30", "--distance-mm", "100")
    assert refused(lambda: trueaxis.evaluate_thermal(record, period_min=0)) == "period_min: found 0, needed 0.1 to 100000 min"
    assert refused(lambda: trueaxis.evaluate_thermal(record, test="hot")).startswith('test: found "hot"')


def test_ring(tmp_path):
    turn = np.tile(np.linspace(0, 2 * np.pi, 36, endpoint=False), 2)
    record = {"x_mm": 22 * np.cos(turn), "y_mm": 22 * np.sin(turn) + NOISE.normal(0, 2e-4, 72), "run": np.repeat([1.0, 2.0], 36)}
    call = lambda record: trueaxis.evaluate_probing(record, feature="ring", diameter_mm=50)
    found = same_as_command(tmp_path, "probing", record, call, "--feature", "ring", "--diameter-mm", "50")
    assert call(pandas.DataFrame(record)) == found
    assert found["effective_tip_diameter_mm"] == pytest.approx(6, abs=1e-3) and len(found["runs"]) == 2


def test_refusals_of_a_record():
    call = lambda record: trueaxis.evaluate_probing(record, feature="ring")
    x = np.arange(5.0)
    assert refused(lambda: call([1, 2]), TypeError) == "record: found list, needed a path, a file object, or a dict or data frame of columns"
    assert refused(lambda: call(io.BytesIO(b"x_mm,y_mm\n1,\xff\n"))) == 'record:2: found bytes that are not UTF-8, needed text in UTF-8'
    assert "needed text or bytes" in refused(lambda: call(types.SimpleNamespace(read=lambda: 3)), TypeError)
    assert refused(lambda: call({"x_mm": x, "w": x})).startswith('record: found column "w", needed some of x_mm, y_mm')
    assert refused(lambda: call({"x_mm": x, "y_mm": x[:4].copy()})).startswith("y_mm: found shape (4,)")
    assert refused(lambda: call({"x_mm": x, "y_mm": x.astype(complex)}), TypeError).startswith("y_mm: found dtype complex128")
    assert refused(lambda: call({"x_mm": x})).startswith("record")
    assert refused(lambda: call({})).startswith("record")
    assert refused(lambda: trueaxis.evaluate_probing({"x_mm": x, "y_mm": x}, feature="cone")).startswith('feature: found "cone"')
    assert refused(lambda: call("nowhere.csv"), FileNotFoundError).startswith("cannot read nowhere.csv")
