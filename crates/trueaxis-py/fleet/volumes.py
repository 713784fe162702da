"""Volumetric figures of a fleet on Dask, and how they scale: `python volumes.py [MACHINES]`, 10,000 by default.

`volumes` evaluates every machine at a grid of positions. Run as a program, the file draws machines at random, evaluates them
with one worker process and with as many as there are cores, and prints machines per second.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import dask
import numpy as np
import pandas as pd

import trueaxis

TRAVEL = {"X": (0.0, 300.0), "Y": (0.0, 200.0), "Z": (-200.0, 0.0)}
# Machines a task: some tenths of a second of work, which makes Dask's millisecond a task negligible.
BATCH = 100


def _batch(machines: Sequence[str], travel: Sequence[tuple[float, float]], points: int) -> list[dict[str, Any]]:
    axes = (np.linspace(low, high, points) for low, high in travel)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(travel))
    rows = []
    for machine in machines:
        try:
            error = trueaxis.Machine.load(machine).error(grid, model="volumetric")
        except (trueaxis.Error, FileNotFoundError) as refused:
            rows.append({"machine": Path(machine).name, "refused": str(refused)})
            continue
        size = np.linalg.norm(error, axis=1)
        span = np.ptp(error, axis=0)
        rows.append({"machine": Path(machine).name, "max_um": size.max(), "rms_um": np.sqrt(np.mean(size**2)),
                     "span_x_um": span[0], "span_y_um": span[1], "span_z_um": span[2], "refused": None})
    return rows


def volumes(machines: Iterable[str | Path], travel: Sequence[tuple[float, float]], points: int = 9) -> pd.DataFrame:
    """Evaluates the volumetric error of every machine at `points` positions along each axis of `travel`, mm.

    The table has a row for every machine, in the order of the arguments: machine, max_um and rms_um of the error's length,
    span_x_um, span_y_um, span_z_um (largest − smallest component), refused. A refused machine has the reason there; the others
    continue.
    """
    paths = [str(machine) for machine in machines]
    tasks = [dask.delayed(_batch)(paths[at:at + BATCH], list(travel), points) for at in range(0, len(paths), BATCH)]
    columns = ["machine", "max_um", "rms_um", "span_x_um", "span_y_um", "span_z_um", "refused"]
    return pd.DataFrame([row for rows in dask.compute(*tasks) for row in rows], columns=columns)


def draw(folder: Path, number: int) -> Path:
    """Writes a machine of three axes with their twenty-one errors, drawn from its number."""
    random = np.random.default_rng([9, number])
    at = folder / f"mill-{number:05}"
    at.mkdir()
    toml = [f'name = "{at.name}"', 'chain = "w X\' Y\' b Z t"', "[location]"]
    toml += [f"{term} = {random.normal(0, 25):.2f}" for term in ("A0Z_urad", "B0Z_urad", "C0Y_urad")]
    for axis, (low, high) in TRAVEL.items():
        x = np.linspace(low, high, 21)
        s = (x - low) / (high - low)
        columns = [x]
        columns += [random.normal(0, 12 if of == axis else 3) * s + random.normal(0, 2) * np.sin(6 * s) for of in "XYZ"]
        columns += [random.normal(0, 15) * s + random.normal(0, 5) * np.sin(np.pi * s) for _ in "ABC"]
        header = ",".join([f"{axis}_mm", *(f"E{of}{axis}_um" for of in "XYZ"), *(f"E{of}{axis}_urad" for of in "ABC")])
        np.savetxt(at / f"{axis.lower()}.csv", np.column_stack(columns), fmt="%.4f", delimiter=",", header=header, comments="")
        toml += [f"[axis.{axis}]", f'table = "{axis.lower()}.csv"', 'interpolation = "cubic"', f"travel_mm = [{low}, {high}]",
                 "max_feed_mm_per_min = 6000.0"]
    (at / "machine.toml").write_text("\n".join(toml) + "\n")
    return at


def main() -> None:
    from dask.distributed import Client, LocalCluster

    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    cores = os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as folder:
        machines = [draw(Path(folder), number) for number in range(count)]
        print(f"{count} machines, {9**3} positions of each\n\n| workers | s | machines/s | scaling |\n|---|---|---|---|")
        tables, alone = [], 0.0
        for workers in sorted({1, cores}):
            with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
                client.upload_file(__file__)
                # A task to each worker first: importing takes longer than a batch.
                client.run(lambda: trueaxis.Machine)
                begun = time.perf_counter()
                tables.append(volumes(machines, list(TRAVEL.values())))
                seconds = time.perf_counter() - begun
            alone = alone or seconds
            print(f"| {workers} | {seconds:.2f} | {count / seconds:.0f} | {alone / seconds:.2f} |", flush=True)
        for table in tables[1:]:
            pd.testing.assert_frame_equal(tables[0], table, check_exact=True)
        print(f"\n{tables[0].describe().round(2)}")


if __name__ == "__main__":
    main()
