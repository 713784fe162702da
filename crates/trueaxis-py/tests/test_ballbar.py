"""Circular tests, compared with the command line and with the errors in the generated record."""

import json

import numpy as np
import pytest

import trueaxis
from shared import refused
from test_command_line import TABLES, command, written

RADIUS = 100.0
SQUARENESS, BACKLASH = 40e-6, 0.003  # rad; mm, of X


def record():
    """A record of two turns in each direction: a squareness, a backlash of X and noise of 0.05 µm."""
    rows, noise = [], np.random.default_rng(5)
    for direction in (1, -1):
        angle = np.arange(0.25, 720.0, 0.5)
        t = np.radians(angle)
        mm = -0.5 * RADIUS * SQUARENESS * np.sin(2 * t) + 0.5 * direction * BACKLASH * np.sign(np.sin(t)) * np.cos(t)
        rows.append(np.column_stack([angle, 1e3 * mm + noise.normal(0, 0.05, len(angle)), np.full(len(angle), direction)]))
    return np.vstack(rows)


def test_a_test_is_that_of_the_command(tmp_path):
    rows = record()
    file = written(tmp_path / "record.csv", "angle_deg,deviation_um,direction", rows)
    code, out, err = command("ballbar", file, "--radius-mm", "100", "--pitch-x-mm", "10", "--json")
    assert code == 0, err
    found = trueaxis.ballbar(rows, radius_mm=100.0, pitch_x_mm=10.0)
    assert found == json.loads(out) == trueaxis.ballbar(file, radius_mm=100, pitch_x_mm=10)
    assert found["squareness_urad"] == pytest.approx(1e6 * SQUARENESS, abs=0.5)
    assert found["backlash_um"]["x"] == pytest.approx(1e3 * BACKLASH, abs=0.1)
    assert found["sigma_um"] == pytest.approx(0.05, rel=0.1)
    machine = TABLES / "mill-3axis"
    code, out, err = command("ballbar", file, "--radius-mm", "100", "--machine", machine, "--json", "--dry-run")
    assert code == 0, err
    decided = trueaxis.ballbar(file, radius_mm=100.0, machine=trueaxis.Machine.load(machine))["written"]
    assert decided == json.loads(out)["written"] and "axis.X.backlash_um" in {of["key"] for of in decided}
    traces = trueaxis.ballbar(rows, radius_mm=100.0, pitch_x_mm=10.0, traces=True).to_dict()
    centred, left = traces.pop("centred_um"), traces.pop("left_um")
    assert np.allclose(traces.pop("angle_deg"), rows[:, 0]) and np.array_equal(traces.pop("direction"), rows[:, 2])
    assert traces == found and centred.shape == left.shape == (len(rows),)
    assert np.ptp(centred) == pytest.approx(found["g_b_um"], rel=0.01)
    # The median ignores the few readings at reversals, where the axis has not taken up its play and which the fit omits.
    scatter = np.median(np.abs(left)) / 0.6745
    assert scatter == pytest.approx(0.05, rel=0.1) and centred.std() > 10 * scatter
    assert np.mean(np.abs(left) > 0.3) < 0.1


def test_causes_have_a_covariance():
    """Their covariance has the standard errors that are printed."""
    found = trueaxis.ballbar(record(), radius_mm=RADIUS, pitch_x_mm=10.0, pitch_y_mm=10.0)
    numbers, errors = found.to_ufloats(), found.standard_errors
    assert numbers["backlash_um.x"].nominal_value == found.backlash_um.x
    assert numbers["backlash_um.x"].std_dev == pytest.approx(errors["backlash_um"]["x"])
    assert numbers["centre_um[1]"].std_dev == pytest.approx(errors["centre_um"][1])
    assert np.linalg.eigvalsh(found.correlation).min() > -1e-9
    names = found.covariance.names
    # A bow of an axis is mistaken for an offset of the centre across it.
    assert abs(found.correlation[names.index("straightness_um.x"), names.index("centre_um[1]")]) > 0.3


def test_positions_in_another_plane_are_those_of_the_command(tmp_path):
    """Positions in Z and X that differ from the command by a squareness only, with an approach before the circle."""
    t = np.concatenate([np.radians(np.arange(0, 720, 0.25)), np.radians(np.arange(720, 0, -0.25))])
    z, x = RADIUS * np.cos(t), RADIUS * np.sin(t)
    rows = np.column_stack([z, z - 30e-6 * x, x, x])
    file = written(tmp_path / "record.csv", "z_cmd_mm,z_mm,x_cmd_mm,x_mm", rows)
    code, out, err = command("ballbar", file, "--radius-mm", "100", "--axes", "Z,X", "--json")
    assert code == 0, err
    found = trueaxis.ballbar(rows, radius_mm=100, axes="Z,X")
    assert found == json.loads(out) and found["plane"] == "ZX"
    assert abs(found["squareness_urad"]) == pytest.approx(30, abs=0.5)


def test_refusals():
    rows = record()
    assert refused(lambda: trueaxis.ballbar(rows, radius_mm=0.0)) == "radius_mm: found 0, needed 0.001 to 100000 mm"
    assert refused(lambda: trueaxis.ballbar(rows, radius_mm=100, pitch_y_mm=float("nan"))).startswith("pitch_y_mm: found NaN")
    assert refused(lambda: trueaxis.ballbar(rows[:, :2].copy(), radius_mm=100)).startswith("record: found shape (2880, 2)")
    assert refused(lambda: trueaxis.ballbar(rows, radius_mm=100, axes="X,A")).startswith("axes: ")
    rows[7, 2] = 0.0
    assert refused(lambda: trueaxis.ballbar(rows, radius_mm=100)).startswith("record:9: column direction: found 0")
    assert refused(lambda: trueaxis.ballbar("nowhere.csv", radius_mm=100), FileNotFoundError).startswith("cannot read nowhere.csv")
