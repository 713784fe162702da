"""Sweeps on Dask: any number of workers gives the same table, a refusal affects one row, other tools read the Parquet files."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import duckdb
import nbformat
import numpy as np
import pandas as pd
import polars
import pytest
from dask.distributed import Client, LocalCluster
from nbclient import NotebookClient

import trueaxis

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE / "fleet"))
import volumes  # noqa: E402
from sweep import sweep  # noqa: E402

SAMPLES = HERE.parents[1] / "compensation-tables"
PART = {"corner": "G21 G90 F3000\nG1 X20 Y20\nG1 X0\nG1 Y0\nM2\n", "line": "G21 G90 F1000\nG1 X3\nM2\n"}
GIVEN = {"rate_hz": 1000, "cases": {"cold": {"temperature_c": 20.0}, "warm": {"temperature_c": 24.0}}}
MACHINES = [SAMPLES / "mill-3axis", SAMPLES / "mill-5axis"]


def test_every_number_of_workers_gives_the_same_table():
    here = sweep(MACHINES, PART, range(3), **GIVEN)
    tables = []
    for workers in (1, 3):
        with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            client.upload_file(str(HERE / "fleet" / "sweep.py"))
            tables.append(sweep(MACHINES, PART, range(3), **GIVEN))
    for table in tables:
        pd.testing.assert_frame_equal(here, table, check_exact=True)
    assert here.groupby(["machine", "program", "seed", "case"]).ngroups == 2 * 2 * 3 * 2
    row = here[(here.machine == "mill-3axis") & (here.program == "line") & (here.seed == 2) & (here.case == "warm")]
    alone = trueaxis.simulate(trueaxis.Machine.load(MACHINES[0]), trueaxis.Program.from_text(PART["line"]), seed=2, rate_hz=1000,
                              temperature_c=24.0)
    assert dict(zip(row.kind, row.digest)) == alone["digest"]
    assert dict(zip(row.kind, row.contour_max_um)) == {kind: of["max"] for kind, of in alone["contour_error_um"].items()}


def test_volumes_of_a_fleet_do_not_depend_on_the_number_of_workers(tmp_path, monkeypatch):
    monkeypatch.setattr(volumes, "BATCH", 7)
    machines = [volumes.draw(tmp_path, number) for number in range(30)]
    (tmp_path / "broken").mkdir()
    machines.insert(3, tmp_path / "broken")
    travel = list(volumes.TRAVEL.values())
    here = volumes.volumes(machines, travel, points=5)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.upload_file(str(HERE / "fleet" / "volumes.py"))
        pd.testing.assert_frame_equal(here, volumes.volumes(machines, travel, points=5), check_exact=True)
    assert list(here.machine) == [machine.name for machine in machines] and list(here.index[here.refused.notna()]) == [3]
    # The largest error is at one of the grid's points.
    grid = np.stack(np.meshgrid(*(np.linspace(*of, 5) for of in travel)), -1).reshape(-1, 3)
    errors = trueaxis.Machine.load(machines[20]).error(grid, model="volumetric")
    assert here.max_um[20] == pytest.approx(max(sum(e * e for e in row) ** 0.5 for row in errors), rel=1e-12)


def test_settings_of_a_machine_and_what_is_refused(tmp_path):
    shutil.copytree(MACHINES[0], tmp_path / "worn")
    (tmp_path / "broken").mkdir()
    machines = [MACHINES[0], tmp_path / "worn", tmp_path / "broken", tmp_path / "none"]
    table = sweep(machines, {**PART, "far": "G21 G90 F1000\nG1 X9000\nM2\n"}, rate_hz=1000, kinds=["compensated"],
                  of_machine={"worn": {"axis.X.lost_motion_mm": 0.02}})
    assert list(table.refused.isna()) == [True, True, False] * 2 + [False] * 6
    good = table[table.refused.isna()].set_index(["machine", "program"]).contour_max_um
    assert good["worn", "corner"] > good["mill-3axis", "corner"] + 5.0
    assert "machine.toml" in table.refused[6] and "X" in table.refused[2]
    with pytest.raises(ValueError, match="found no run"):
        sweep([], PART)
    with pytest.raises(TypeError):
        sweep([MACHINES[0]], PART, rate_in_hz=1000)


def test_the_notebook_runs(tmp_path):
    shutil.copy(HERE / "fleet" / "sweep.py", tmp_path)
    notebook = nbformat.read(HERE / "fleet" / "fleet.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells)
    NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert (tmp_path / "figures" / "fleet.png").stat().st_size > 10_000
    said = "".join(output.data["text/plain"] for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output)
    # Each verdict applies to some of the 200 machines.
    assert "a new screw" in said and "a grid" in said and "nothing" in said


@pytest.mark.skipif("TRUEAXIS_SIMULATOR" not in os.environ, reason="TRUEAXIS_SIMULATOR: firmware-sim")
def test_columns_of_a_run_are_read_by_others(tmp_path):
    """trace.parquet contains the columns of trace.csv, not rounded; result.parquet, the figures of `run --json`."""
    run = [os.environ["TRUEAXIS_SIMULATOR"], "run", "--rate-hz", "1000", "--trace-every", "7", "--report", tmp_path, "--parquet", tmp_path]
    subprocess.run(run, check=True, capture_output=True)
    for name in ("trace", "trace-full"):
        text = pd.read_csv(tmp_path / f"{name}.csv")
        columns = polars.read_parquet(tmp_path / f"{name}.parquet")
        assert columns.columns == list(text.columns) and len(columns) == len(text) > 5_000
        for column in text:
            off = np.abs(columns[column].to_numpy() - text[column].to_numpy())
            assert np.nanmax(off) <= 0.51 * 10.0 ** -(4 if "deg" in column or "urad" in column else 5), column
        assert columns["line"].dtype == polars.Int64
    kinds = duckdb.sql(f"select kind, contour_error_um_max, seed from '{tmp_path}/result.parquet'".replace("seed", "settings_seed"))
    made = trueaxis.simulate(trueaxis.Machine.load(MACHINES[0]), trueaxis.Program.load("circle-diamond-square"), rate_hz=1000)
    assert {kind: largest for kind, largest, _ in kinds.fetchall()} == {k: of["max"] for k, of in made["contour_error_um"].items()}


@pytest.mark.skipif("TRUEAXIS_HOSTS" not in os.environ, reason="TRUEAXIS_HOSTS: the folder of tests/hosts/recording.sh")
def test_telemetry_is_read_by_others(tmp_path):
    """Telemetry of the hosts' recording, as a controller sends it, equals the step's output."""
    hosts = Path(os.environ["TRUEAXIS_HOSTS"])
    frames, table = tmp_path / "frames.bin", tmp_path / "telemetry.parquet"
    replay = [os.environ["TRUEAXIS_SIMULATOR"], "replay", hosts / "run.rec", hosts / "machine.tcomp", "-o", tmp_path / "run.csv",
              "--telemetry", frames]
    subprocess.run(replay, check=True, capture_output=True)
    subprocess.run([os.environ["TRUEAXIS_COMMAND"], "telemetry", frames, "-o", table], check=True, capture_output=True)
    sent, found = pd.read_csv(tmp_path / "run.csv"), pd.read_parquet(table)
    assert len(found) == len(sent) and (found.sequence == np.arange(len(sent))).all() and found.machine_id.nunique() == 1
    for axis in "xyz":
        assert (found[f"{axis}_command_mm"] == sent[f"{axis}_cmd_mm"]).all() and (found[f"{axis}_feedback_mm"] == sent[f"{axis}_mm"]).all()
        drive = found[f"{axis}_command_mm"] + found[f"{axis}_correction_mm"]
        assert np.abs(drive - sent[f"{axis}_drive_mm"]).max() < 5e-9
    largest = duckdb.sql(f"select max(abs(tip_error_mm)) from '{table}' where fault = 0").fetchall()[0][0]
    assert largest == found.tip_error_mm.abs().max() > 0.0


def test_which_machines_may_cut_a_part(tmp_path, monkeypatch):
    monkeypatch.setenv("TRUEAXIS_FLEET", "8")
    folder = tmp_path / "crates" / "trueaxis-py" / "fleet"
    folder.mkdir(parents=True)
    shutil.copytree(HERE.parents[1] / "records" / "plate", tmp_path / "records" / "plate")
    shutil.copy(HERE / "fleet" / "volumes.py", folder)
    notebook = nbformat.read(HERE / "fleet" / "part.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells)
    NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(folder)}}).execute()
    assert (folder / "figures" / "part.png").stat().st_size > 10_000
    said = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []))
    found = re.search(r"(\d+) of 8 machines may cut the plate; the best is mill-0000\d", said)
    # Some may and some may not.
    assert found and 0 < int(found[1]) < 8
