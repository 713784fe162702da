"""A machine that keeps itself true: Python, and the command on a copy of the same folder, change it alike."""

import json
import shutil

import pytest

import probing
import trueaxis
from shared import refused
from test_command_line import command

START, LATER = "2026-05-04T06:00:00Z", "2026-05-04T07:00:00Z"


def tree(folder):
    """Contents of all files except the logs, by path."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.suffix != ".log")
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def look(folder, name, seed, *offsets_um):
    """Probes the ball; returns the path of the log."""
    program = trueaxis.keep_plan(folder / "keep.toml")["program_text"]
    log = folder / name
    log.write_text(probing.run(program, probing.moved(*offsets_um), seed))
    return log


@pytest.fixture
def folder(tmp_path):
    """A task with its first probing in the history."""
    folder = tmp_path / "own"
    (folder / "mill").mkdir(parents=True)
    (folder / "mill" / "machine.toml").write_text(probing.MACHINE)
    (folder / "keep.toml").write_text(probing.KEEP)
    trueaxis.keep_begin(folder / "keep.toml", look(folder, "begin.log", 4, 0, 0, 0), time=START, parts=0)
    return folder


def answered(folder, verb, *more):
    code, out, err = command("keep", verb, folder / "keep.toml", *more)
    assert code == 0, err
    return json.loads(out) if "--json" in more else out


def test_a_plan_is_that_of_the_command(folder, tmp_path):
    found = trueaxis.keep_plan(folder / "keep.toml").to_dict()
    text = found.pop("program_text")
    assert found == answered(folder, "plan", "-o", tmp_path / "look.ngc", "--json")
    assert text == (tmp_path / "look.ngc").read_text() and "M0" not in text
    assert [term["name"] for term in found["terms"]] == ["offset X", "offset Y", "offset Z"]
    assert all(term["significance"] * term["standard_error"] < term["largest_update"] == 15 for term in found["terms"])


def test_a_round_leaves_the_files_of_the_command(folder, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    shutil.rmtree(other / "mill" / "keep")
    answered(other, "begin", other / "begin.log", "--time", START, "--parts", 0, "--json")
    assert tree(folder) == tree(other)

    log = look(folder, "look.log", 5, 6, 0, -9)
    shutil.copy(log, other)
    more = ["--time", LATER, "--parts", 12, "--json"]
    before = tree(folder)
    found = trueaxis.keep_check(folder / "keep.toml", log, time=LATER, parts=12, files=True).to_dict()
    assert tree(folder) == before
    files, changes = found.pop("files"), found.pop("changes")
    assert found == answered(other, "check", other / "look.log", *more)
    terms = {term["name"]: term for term in found["terms"]}
    for name, truth in [("offset X", 6), ("offset Y", 0), ("offset Z", -9)]:
        assert terms[name]["value"] == pytest.approx(truth, abs=4 * terms[name]["standard_error"])
        assert terms[name]["verdict"] == ("update" if truth else "keep")
    assert found["notes"] == ["12 parts since the last re-probing, every_parts is 10"] and changes

    done = trueaxis.keep_apply(folder / "keep.toml", log, time=LATER, parts=12).to_dict()
    assert done.pop("changes") == changes and done["applied"]
    assert done == answered(other, "apply", other / "look.log", *more)
    assert tree(folder) == tree(other) and (folder / "mill" / "mill.tcomp").exists()
    for name, text in files.items():
        assert (folder / "mill" / name).read_text() == text
    assert set(files) == {"machine.toml", "x.csv", "z.csv"}

    entry = trueaxis.keep_undo(folder / "keep.toml")
    answered(other, "undo")
    assert tree(folder) == tree(other) and (folder / "mill" / "machine.toml").read_text() == probing.MACHINE
    history = trueaxis.keep_history(folder / "keep.toml")
    assert history == answered(other, "history", "--json") and history[-1] == entry
    assert [entry["deed"] for entry in history] == ["begin", "update", "undo"]


def test_a_term_out_of_its_bounds_needs_a_person(folder):
    log, task = look(folder, "far.log", 6, 0, 0, 22), folder / "keep.toml"
    before = tree(folder)
    found = trueaxis.keep_check(task, log, files=True)
    assert found["refused"] == 1 and found["files"] == {}
    code, _, err = command("keep", "apply", task, log)
    with pytest.raises(trueaxis.NeedsPerson) as caught:
        trueaxis.keep_apply(task, log)
    assert code == 3 and str(caught.value) == err.strip().splitlines()[-1].removeprefix("error: ")
    assert "offset Z moved by 22" in str(caught.value) and tree(folder) == before
    assert trueaxis.keep_apply(task, log, accept=["offset Z"])["applied"]


def test_bad_reprobings_are_refused_in_the_words_of_the_command(folder):
    task, log = folder / "keep.toml", look(folder, "look.log", 5, 6, 0, -9)
    lines = log.read_text().splitlines()
    cases = {
        "missing.log": [line for line in lines if not line.startswith("touch 4 ")],
        "twice.log": [*lines, lines[4]],
        "other.log": ["trueaxis calibrate 00000001 touches 81", *lines[1:]],
    }
    before = tree(folder)
    for name, of in cases.items():
        (folder / name).write_text("\n".join(of) + "\n")
        code, _, err = command("keep", "apply", task, folder / name)
        assert code == 2
        words = err.strip().removeprefix("error: ")
        assert refused(lambda: trueaxis.keep_check(task, folder / name)) == words
        assert refused(lambda: trueaxis.keep_apply(task, folder / name)) == words
    assert refused(lambda: trueaxis.keep_check(task, log, time="yesterday")).startswith('time: found "yesterday", needed a time')
    assert refused(lambda: trueaxis.keep_check(task, log, accept=["offset W"])).startswith('accept: found "offset W", needed one of')
    assert "no update since the beginning" in refused(lambda: trueaxis.keep_undo(task))
    assert tree(folder) == before
    (folder / "mill" / "machine.toml").write_text(probing.MACHINE + "# by hand\n")
    assert "changed by hand" in refused(lambda: trueaxis.keep_apply(task, log))
    with pytest.warns(UserWarning, match="used as they are"):
        assert trueaxis.keep_apply(task, log, by_hand=True)["applied"]
    (folder / "mill" / "keep" / "history.jsonl").unlink()
    assert "no beginning" in refused(lambda: trueaxis.keep_check(task, log))
