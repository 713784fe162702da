"""Corrections at the positions of the recording that every host of trueaxis replays, compared with those of the step."""

import csv
import json
import os
from pathlib import Path

import numpy as np
import pytest
import trueaxis


@pytest.mark.skipif("TRUEAXIS_HOSTS" not in os.environ, reason="TRUEAXIS_HOSTS: the folder of tests/hosts/recording.sh")
def test_corrections_are_those_of_the_step():
    results = Path(os.environ["TRUEAXIS_HOSTS"])
    with (results / "run.csv").open() as file:
        # The first cycle sends the command without correction.
        rows = [row for row in list(csv.DictReader(file))[1:] if row["limited"] == row["fault"] == "0"]
    command, drive = (np.array([[float(row[f"{axis}_{of}mm"]) for axis in "xyz"] for row in rows]) for of in ("cmd_", "drive_"))
    corrected = command + trueaxis.Machine.load(results / "machine.tcomp").correction(command)
    off = np.abs(corrected - drive)
    found = {"host": "python", "samples": off.size, "same": int((off == 0.0).sum()), "largest_mm": float(off.max())}
    (results / "python.json").write_text(json.dumps(found) + "\n")
    assert off.size > 10_000 and off.max() < 2e-6 and np.abs(drive - command).max() > 5e-3
