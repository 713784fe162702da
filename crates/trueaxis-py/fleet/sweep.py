"""Simulated runs over machines, programs and seeds, on Dask.

`sweep` turns every run into a task and collects the results in a table. Dask executes the tasks in the threads of this
process, or on the workers of an open `distributed.Client` (they need this file and the package `trueaxis`). The table does
not depend on the number of workers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import dask
import pandas as pd

import trueaxis

# Columns with a run's results; they are empty if the run was refused.
FIGURES = ("contour_max_um", "contour_rms_um", "digest", "cycles", "limited_cycles", "stopped", "faults")


def _run(machine: str, program: str, text: str | None, seed: int, case: str, given: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Simulates one run; returns one row for each kind of machine."""
    of = {"machine": Path(machine).name, "program": program if text else Path(program).stem, "seed": seed, "case": case}
    try:
        part = trueaxis.Program.from_text(text, name=program) if text else trueaxis.Program.load(program)
        made = trueaxis.simulate(trueaxis.Machine.load(machine), part, seed=seed, **given)
    except (trueaxis.Error, FileNotFoundError) as refused:
        return [{**of, "kind": None, **dict.fromkeys(FIGURES), "refused": str(refused)}]
    rows = []
    for kind, error in made["contour_error_um"].items():
        figures = (error["max"], error["rms"], made["digest"].get(kind), made["cycles"], made["limited_cycles"], made["stopped"],
                   len(made["faults"]))
        rows.append({**of, "kind": kind, **dict(zip(FIGURES, figures)), "refused": None})
    return rows


def sweep(
    machines: Iterable[str | Path],
    programs: Sequence[str | Path] | Mapping[str, str],
    seeds: Iterable[int] = (1,),
    *,
    cases: Mapping[str, Mapping[str, Any]] | None = None,
    of_machine: Mapping[str, Mapping[str, Any]] | None = None,
    **given: Any,
) -> pd.DataFrame:
    """Simulates every machine with every program, seed and case.

    - machines: paths for `Machine.load`, valid on the workers.
    - programs: arguments of `Program.load`, or names with their texts.
    - cases: names with arguments of `trueaxis.simulate` for each case.
    - of_machine: settings of the simulation, such as {"axis.X.lost_motion_mm": 0.004}, by the name of a machine's folder.
    - given: further arguments of every run, such as kinds=["compensated"] or rate_hz=1000.

    The table has a row for every run and kind of machine, in the order of the arguments: machine, program, seed, case, kind,
    then the figures. A refused machine or program has one row with the reason under `refused`; the others continue.
    """
    texts = programs if isinstance(programs, Mapping) else {str(program): None for program in programs}
    tasks = []
    for machine in map(str, machines):
        settings = (of_machine or {}).get(Path(machine).name, {})
        for program, text in texts.items():
            for case, more in (cases or {"": {}}).items():
                arguments = {**given, **more, "settings": {**settings, **given.get("settings", {}), **more.get("settings", {})}}
                tasks += [dask.delayed(_run)(machine, program, text, seed, case, arguments) for seed in list(seeds)]
    if not tasks:
        raise ValueError("found no run, needed a machine, a program and a seed at least")
    rows = [row for rows in dask.compute(*tasks) for row in rows]
    return pd.DataFrame(rows).astype({"contour_max_um": "float64", "contour_rms_um": "float64"})
