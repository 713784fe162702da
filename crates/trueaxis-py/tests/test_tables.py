"""Tables of other controls, and tables changed in Python: what is written is what the command writes, or what the file was."""

import pickle
import shutil

import numpy as np
import pandas as pd
import pytest

import trueaxis
from shared import refused
from test_command_line import ROOT, TABLES, command

MEASURED = TABLES / "mill-3axis/x-iso230-2.csv"


def tree(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(TABLES / "mill-3axis", tmp_path / "mill")
    return tmp_path / "mill"


def test_an_import_is_that_of_the_command(folder, tmp_path):
    """Into a new machine, and into one that there is."""
    for own in ("new", "mill"):
        other = tmp_path / f"{own}-of-the-command"
        if own == "mill":
            shutil.copytree(folder, other)
        code, _, err = command("tables", "import", "--from", "iso230-2", "--axis", "X", MEASURED, "-o", other)
        assert code == 0, err
        found = trueaxis.import_table(MEASURED, tmp_path / own, format="iso230-2", axis="X")
        assert tree(tmp_path / own) == tree(other)
        assert repr(found).replace(str(tmp_path / own), "here") == err.rstrip("\n").replace(str(other), "here")
        assert found.format == "iso230-2" and str(tmp_path / own / "x.csv") in found.written
        assert trueaxis.Machine.load(tmp_path / own).table("X")["X_mm"].size == 21


def test_columns_of_other_names_are_read(tmp_path):
    file = tmp_path / "laser.csv"
    file.write_text("Pos (mm),Out (um),Back (um)\n0,0,1\n100,2,3.5\n200,3,4\n")
    names = {"position": "Pos (mm)", "forward": "Out (um)", "reverse": "Back (um)"}
    trueaxis.import_table(file, tmp_path / "mill", format="columns", axis="X", columns=names)
    table = trueaxis.Machine.load(tmp_path / "mill").table("X")
    assert table["EXX_fwd_um"].tolist() == [0, 2, 3] and table["EXX_rev_um"].tolist() == [1, 3.5, 4]


def test_an_import_is_refused_in_the_names_of_arguments(tmp_path):
    file = tmp_path / "x.comp"
    file.write_text("0 0.001 0.001\n10 10.002 10.002\n20 20.001 20.001\n")
    call = lambda **more: trueaxis.import_table(file, tmp_path / "mill", **{"format": "linuxcnc", "axis": "X", **more})
    for more, needed in (
        ({"format": "lathe"}, 'format: found "lathe", needed linuxcnc, '),
        ({"comp_file_type": 2}, "comp_file_type: found 2, needed 0 or 1"),
        ({"axis": "Q"}, "axis: found 'Q', needed X, Y"),
        ({"unit": "furlong"}, 'unit: found "furlong", needed mm or inch'),
        ({"columns": {"position": "a"}}, "columns: found it with linuxcnc"),
        ({"area_mm": [1, 2]}, "area_mm: found [1.0, 2.0], needed the lowest X and Y"),
        ({}, f"{file}: found lengths of axis X without a unit, needed unit mm or unit inch"),
    ):
        assert refused(lambda: call(**more)).startswith(needed)
    assert not (tmp_path / "mill").exists()
    refused(lambda: trueaxis.import_table(tmp_path / "nowhere", tmp_path / "mill", format="isg"), FileNotFoundError)


def test_an_export_is_that_of_the_command(tmp_path):
    machine = trueaxis.Machine.load(TABLES / "head-5axis")
    code, _, err = command("tables", "export", "--to", "isg", TABLES / "head-5axis", "-o", tmp_path / "other.csv", "--drop")
    assert code == 0, err
    found = trueaxis.export_table(machine, tmp_path / "own.csv", format="isg", drop=True)
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert repr(found).replace("own.csv", "other.csv") == err.rstrip("\n")
    assert refused(lambda: trueaxis.export_table(machine, tmp_path / "own.csv", format="bed-mesh"))
    compiled = tmp_path / "head.tcomp"
    with pytest.warns(UserWarning):
        compiled.write_bytes(machine.compile())
    assert refused(lambda: trueaxis.export_table(trueaxis.Machine.load(compiled), tmp_path / "a", format="isg")).startswith("machine: found a compiled file")


def test_a_changed_table_keeps_the_comments_of_its_file(folder):
    """A value, a row that is new and one that is gone: every other line of the file is as it was."""
    mill = trueaxis.Machine.load(folder)
    before = (folder / "x.csv").read_text().splitlines()
    table = pd.DataFrame(mill.table("X"))
    table.loc[table["X_mm"] == -300, "EAX_urad"] = 1.25
    table = table[table["X_mm"] != -280]
    new = table[table["X_mm"] == -290].assign(X_mm=-295.0, EXX_fwd_um=14.5)
    table = pd.concat([table, new]).sort_values("X_mm")
    made = mill.with_table("X", table)
    assert made != mill and pd.DataFrame(made.table("X")).equals(table.reset_index(drop=True))
    assert pickle.loads(pickle.dumps(made)) == made
    assert made.save() == [folder / "x.csv"]
    after = (folder / "x.csv").read_text().splitlines()
    assert [line for line in after if line not in before] == ["-300,14.551,16.058,6.2,-5.765,1.25,9.578,-9.313", "-295,14.5,16.009,5.844,-5.821,-10.173,9.358,-9.509"]
    assert [line for line in before if line not in after] == [line for line in before if line.startswith(("-300,", "-280,"))]
    assert trueaxis.Machine.load(folder) == made
    assert made.save() == []


def test_a_setting_changes_alone(folder, tmp_path):
    mill = trueaxis.Machine.load(folder)
    before = (folder / "machine.toml").read_text()
    made = mill.with_setting("axis.Y.backlash_um", 2.5).with_setting("compensation.model", "volumetric")
    assert made.model == "volumetric" and mill.model == trueaxis.Machine.load(folder).model
    assert set(path.name for path in made.save(tmp_path / "copy")) >= {"machine.toml", "x.csv", "y.csv"}
    assert (folder / "machine.toml").read_text() == before
    assert trueaxis.Machine.load(tmp_path / "copy") == made
    comments = lambda text: [line.partition("#")[2] for line in text.splitlines() if "#" in line]
    assert comments((tmp_path / "copy/machine.toml").read_text()) == comments(before)
    assert refused(lambda: mill.with_setting("axis.Y.backlash_um", -9e9)).startswith("machine.toml:28: key axis.Y.backlash_um: found -9000000000.0, needed -1000 to 1000 um")
    assert refused(lambda: made.save(tmp_path / "copy")).startswith("folder: found a machine in")


def test_a_table_that_the_machine_cannot_have_is_refused(folder):
    mill = trueaxis.Machine.load(folder)
    table = mill.table("X")
    for change, needed in (
        ({"EXX_fwd_um": table["EXX_fwd_um"][:-1]}, "EXX_fwd_um: found shape"),
        ({"other": table["X_mm"]}, "table: found columns "),
        ({"X_mm": table["X_mm"][::-1]}, "table[1]: found position 290, needed more than 300"),
        ({"EXX_fwd_um": 1e6 * np.sign(table["X_mm"])}, ""),
    ):
        assert refused(lambda: mill.with_table("X", table | change)).startswith(needed)
    assert refused(lambda: mill.table("B")).startswith("axis: found B, which has no table")


def test_what_somebody_else_has_changed_is_not_overwritten(folder):
    mill = trueaxis.Machine.load(folder)
    table = mill.table("X")
    table["EXX_fwd_um"] = table["EXX_fwd_um"] + 0.5
    made = mill.with_table("X", table)
    (folder / "x.csv").write_text((folder / "x.csv").read_text() + "# by hand\n")
    assert "found changes since the machine was loaded" in refused(made.save)
    assert (folder / "x.csv").read_text().endswith("# by hand\n")


def test_learning_is_that_of_the_command(tmp_path):
    record = tmp_path / "part1.csv"
    s = np.linspace(0, 60, 1200)
    rows = np.column_stack([s, 3 * np.sin(s / 7), np.cos(s / 5), 0.5 * np.sin(s / 3), np.ones(1200)])
    head = "# program_id = 1a2b3c4d\n# machine_id = 5e6f7a8b\n# length_mm = 60\ns_mm,ex_um,ey_um,ez_um,measured\n"
    record.write_text(head + "\n".join(",".join(repr(float(value)) for value in row) for row in rows) + "\n")
    for more, options in (({}, []), ({"table": tmp_path / "own.tlearn", "gain": 0.5}, ["--table", tmp_path / "own.tlearn", "--gain", "0.5"])):
        code, out, err = command("learn", record, *options, "-o", tmp_path / "new.tlearn")
        assert code == 0, err
        found = trueaxis.learn(record, **more)
        assert repr(found) == out.rstrip("\n") and found.table == (tmp_path / "new.tlearn").read_bytes()
        (tmp_path / "own.tlearn").write_bytes(found.table)
    assert found.parts == 2 and found.gain == 0.5
    assert refused(lambda: trueaxis.learn(record, gain=2)).startswith("gain: found 2, needed")
    assert refused(lambda: trueaxis.learn(record, cutoff_mm=-1)).startswith("cutoff_mm: found -1, needed")
    record.write_text(record.read_text().replace("1a2b3c4d", "1a2b3c4e"))
    refused(lambda: trueaxis.learn(record, table=tmp_path / "own.tlearn"))
    refused(lambda: trueaxis.learn(tmp_path / "nowhere.csv"), FileNotFoundError)


def test_growth_is_compiled_as_by_the_command(tmp_path):
    folder = ROOT / "firmware-sim/cortex-m/machine"
    machine = trueaxis.Machine.load(folder)
    code, _, err = command("thermal", "compile", folder / "thermal.toml", "--machine", folder, "-o", tmp_path / "mill.ttherm")
    assert code == 0, err
    assert trueaxis.thermal_compile(folder / "thermal.toml", machine=machine) == (tmp_path / "mill.ttherm").read_bytes()
    assert refused(lambda: trueaxis.thermal_compile(trueaxis.probe_angles(n=64), machine=machine)).startswith("thermal: found ProbeAngles")
    refused(lambda: trueaxis.thermal_compile(tmp_path / "nowhere.toml", machine=machine), FileNotFoundError)


def test_a_trace_is_filtered_before_the_circles():
    """Fifty waves lose half of their size at a cut-off of 50: 2 · 0.5 · 1 µm are left of them, and 4 µm of three lobes but a hair."""
    theta = np.arange(0, 360, 0.25)
    radius = 25 + 0.002 * np.cos(np.radians(3 * theta)) + 0.001 * np.cos(np.radians(50 * theta))
    whole, found = trueaxis.trace_roundness(radius), trueaxis.trace_roundness(radius, upr=50)
    assert whole.lsc.zone_um == pytest.approx(6, abs=0.05) and np.array_equal(whole.radius_mm, radius)
    needed = 0.002 * 2 ** -(3 / 50) ** 2 * np.cos(np.radians(3 * theta)) + 0.0005 * np.cos(np.radians(50 * theta))
    assert found.radius_mm - 25 == pytest.approx(needed, abs=1e-12) and np.array_equal(found.theta_deg, theta)
    points = np.column_stack([found.radius_mm * np.cos(np.radians(theta)), found.radius_mm * np.sin(np.radians(theta))])
    assert trueaxis.circle(points).mzc.zone_um == pytest.approx(found.mzc.zone_um, abs=1e-9)
    with pytest.warns(UserWarning, match="fewer than seven for each of 500"):
        trueaxis.trace_roundness(radius, upr=500)
    assert refused(lambda: trueaxis.trace_roundness(radius, upr=51)).startswith("upr: found 51, needed a cut-off of 15")
    assert refused(lambda: trueaxis.trace_roundness(-radius)).startswith("radius_mm[0]: found -25.003")
