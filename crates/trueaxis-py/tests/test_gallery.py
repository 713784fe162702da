"""Every example of the gallery runs, from the folder of the repository, and says something."""

import runpy
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import pytest

from test_command_line import ROOT

matplotlib.use("agg")
GALLERY = sorted((Path(__file__).parents[1] / "gallery").glob("*.py"))


@pytest.mark.parametrize("example", GALLERY, ids=lambda path: path.stem)
def test_an_example_runs(example, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    runpy.run_path(str(example))
    plt.close("all")
    assert capsys.readouterr().out.strip()


def test_there_are_ten():
    assert len(GALLERY) == 10
