"""The notebooks run from end to end: one draws its three figures, the other makes a machine."""

import shutil
from pathlib import Path

import nbformat
from nbclient import NotebookClient

import trueaxis

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


def test_an_afternoon_makes_a_machine(tmp_path):
    """From four records to a folder with tables, settings and uncertainties, in under 60 lines of code."""
    folder = tmp_path / "crates" / "trueaxis-py"
    folder.mkdir(parents=True)
    for name in ("compensation-tables", "records"):
        shutil.copytree(HERE.parents[1] / name, tmp_path / name)
    notebook = nbformat.read(HERE / "afternoon.ipynb", as_version=4)
    nbformat.validate(notebook)
    code = [line for cell in notebook.cells if cell.cell_type == "code" for line in cell.source.splitlines() if line.strip()]
    assert len(code) < 60 and not any(cell.get("outputs") for cell in notebook.cells)
    NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(folder)}}).execute()
    text = (folder / "afternoon/mill/machine.toml").read_text()
    assert text.startswith("# of my own hand") and "expansion_um_per_m_k = 1" in text and "C0Y_urad" in text
    mill = trueaxis.Machine.load(folder / "afternoon/mill")
    assert mill.table("X")["X_mm"].size == 17 and mill.uncertainty(points=3, trials=500).worst.jacobian.radius_um > 0
