"""The notebook runs from end to end and draws its three figures."""

import shutil
from pathlib import Path

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).resolve().parents[1]


def test_the_notebook_runs(tmp_path):
    folder = tmp_path / "crates" / "trueaxis-py"
    (folder / "figures").mkdir(parents=True)
    shutil.copytree(HERE.parents[1] / "compensation-tables", tmp_path / "compensation-tables")
    notebook = nbformat.read(HERE / "notebook.ipynb", as_version=4)
    NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(folder)}}).execute()
    made = {file.name: file.stat().st_size for file in (folder / "figures").iterdir()}
    assert made.keys() == {"field.png", "circle.png", "roundness.png"} and min(made.values()) > 10_000
    assert all("outputs" not in cell or not cell["outputs"] for cell in nbformat.read(HERE / "notebook.ipynb", 4).cells)
