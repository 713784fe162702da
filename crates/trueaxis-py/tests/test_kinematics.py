"""Transformations and helicoids equal the command line's, bit for bit; both refuse the same input."""

import json

import numpy as np
import pytest

import trueaxis
from shared import refused
from test_command_line import TABLES, columns, command, positions, printed, written

TOOL = ("tip_x_mm", "tip_y_mm", "tip_z_mm", "tool_i", "tool_j", "tool_k")
GEAR = {"module_mm": 4.0, "teeth": 20, "pressure_angle_deg": 20.0, "helix_angle_deg": 15.0, "u_rad": "0.25:0.5:5",
        "theta_rad": "0:0.2:4", "pivot_mm": 150.0}


@pytest.mark.parametrize("sample", ["mill-3axis", "mill-5axis", "head-5axis", "mill-turn"])
def test_forward_and_inverse_are_those_of_the_command(tmp_path, sample):
    machine = trueaxis.Machine.load(TABLES / sample)
    at = positions(machine, 50)
    tip, tool, margin = machine.forward(at)
    file = written(tmp_path / "axes.csv", ",".join(machine.columns), at)
    table = printed("kinematics", "forward", "--machine", TABLES / sample, file)
    assert (columns(table, *TOOL) == np.hstack([tip, tool])).all()
    assert (columns(table, "singularity_margin_deg")[:, 0] == margin).all()
    # A row outside the machine's travel ends both with the same message.
    file = written(tmp_path / "tool.csv", ",".join(TOOL), np.hstack([tip, tool]))
    start = [3.0] * (len(machine.columns) - 3)
    options = ["--start", ",".join(map(str, start))] if start else []
    code, out, err = command("kinematics", "inverse", "--machine", TABLES / sample, file, *options)
    if code:
        assert err.split(": ", 2)[-1].strip().rsplit(": ", 1)[-1] in refused(lambda: machine.inverse(tip, tool, start=start or None))
        return
    found, branch, margin, left = machine.inverse(tip, tool, start=start or None)
    table = printed("kinematics", "inverse", "--machine", TABLES / sample, file, *options)
    assert (columns(table, *machine.columns) == found).all()
    assert (columns(table, "branch")[:, 0] == branch).all() and (columns(table, "singularity_margin_deg")[:, 0] == margin).all()
    assert (columns(table, "direction_error_deg")[:, 0] == left).all() and (left <= 0.1).all()
    back, axis, _ = machine.forward(found)
    assert np.abs(back - tip).max() < 1e-9 and np.abs(axis - tool).max() < 1e-12 + np.radians(left.max())


def test_through_the_vertical():
    machine = trueaxis.Machine.load(TABLES / "mill-5axis")
    tool = np.array([[0.0, -0.008727, 0.999962], [1e-6, 1e-6, 1.0], [-1e-6, 1e-6, 1.0], [0.0, 0.008727, 0.999962]])
    tip = np.tile([10.0, 20.0, -30.0], (4, 1))
    found, _, _, left = machine.inverse(tip, tool, max_step_deg=1.0)
    back, axis, _ = machine.forward(found)
    unit = tool / np.linalg.norm(tool, axis=1)[:, None]
    assert np.ptp(found[:, 4]) < 1e-9 and np.abs(back - tip).max() < 1e-9
    assert np.allclose(np.degrees(np.linalg.norm(np.cross(axis, unit), axis=1)), left, atol=1e-12)
    assert left[1] > 0.0 and left.max() < 1e-4 and left[0] == 0.0 and left[3] == 0.0


def test_another_tool_and_a_branch():
    machine = trueaxis.Machine.load(TABLES / "mill-5axis")
    at = np.array([[10.0, 20.0, -30.0, 25.0, 40.0], [11.0, 20.0, -30.0, 26.0, 41.0]])
    tip, tool, _ = machine.forward(at, tool_mm=[0.0, 0.0, -80.0])
    own, _, _ = machine.forward(at)
    assert np.allclose(np.linalg.norm(tip - own, axis=1), 80.0)
    for branch in ("1", "2"):
        found, which, _, _ = machine.inverse(tip, tool, branch=branch, tool_mm=[0.0, 0.0, -80.0])
        assert (which == int(branch)).all()
    assert "branch" in refused(lambda: machine.inverse(tip, tool, branch="3"))
    assert "start" in refused(lambda: machine.inverse(tip, tool, start=[0.0]))
    assert "max_step_deg" in refused(lambda: machine.inverse(tip, tool, max_step_deg=0.0))
    assert "tool: found 1 rows, needed 2" in refused(lambda: machine.inverse(tip, tool[:1]))
    assert "row 0" in refused(lambda: machine.inverse(tip, 0.0 * tool))
    assert "tool_mm" in refused(lambda: machine.forward(at, tool_mm=[0.0, 0.0, float("nan")]))


def test_helicoids_are_those_of_the_command(tmp_path):
    options = [word for key, value in GEAR.items() for word in ("--" + key.replace("_", "-"), str(value))]
    code, out, err = command("helicoid", *options, "--json", "--gcode", tmp_path / "g.ngc")
    assert code == 0, err
    found = trueaxis.helicoid(gcode=True, **GEAR).to_dict()
    assert found.pop("program") == (tmp_path / "g.ngc").read_text()
    assert found == json.loads(out)
    assert "unknown field `modul_mm`" in refused(lambda: trueaxis.helicoid(**GEAR, modul_mm=3))
    assert "teeth" in refused(lambda: trueaxis.helicoid(**{**GEAR, "teeth": 0}))
