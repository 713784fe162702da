"""The gallery: what its scripts say and draw is what the page and the notebooks have, and a notebook runs."""

import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from test_command_line import ROOT

HERE = Path(__file__).resolve().parents[1]
SCRIPTS = sorted((HERE / "gallery").glob("*.py"))


def test_page_and_notebooks_are_those_of_the_scripts():
    done = subprocess.run([sys.executable, HERE / "gallery.py", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_there_are_ten_questions_with_answers():
    assert len(SCRIPTS) == 10
    page = (ROOT / "docs/gallery.md").read_text()
    questions = [line for line in page.splitlines() if line.startswith("## ")]
    assert len(questions) == 10 and all(question.endswith("?") for question in questions)
    assert page.count("```text\n") == 10 and "```text\n\n```" not in page


def test_a_notebook_of_the_gallery_runs(tmp_path):
    """From the folder that it lies in, as whoever opens it has it."""
    folder = tmp_path / "crates/trueaxis-py/gallery"
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "compensation-tables", tmp_path / "compensation-tables")
    notebook = nbformat.read(HERE / "gallery/01_is_my_axis_in_class.ipynb", as_version=4)
    nbformat.validate(notebook)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    assert "A is 33.856" in "".join(out.get("text", "") for cell in notebook.cells for out in cell.get("outputs", []))
