"""Results: what they print is what the command prints, and their figures, tables and plots are those of the report."""

import json
import pickle

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

import trueaxis
from shared import refused
from test_ballbar import record
from test_command_line import TABLES, command, written

matplotlib.use("agg")
MEASURED = TABLES / "mill-3axis/x-iso230-2.csv"


@pytest.fixture(scope="module")
def ballbar(tmp_path_factory):
    """A circular test, and what the command prints of it: its text and its JSON."""
    file = written(tmp_path_factory.mktemp("ballbar") / "record.csv", "angle_deg,deviation_um,direction", record())
    asked = ("ballbar", file, "--radius-mm", "100", "--pitch-x-mm", "10")
    texts = []
    for more in ((), ("--json",)):
        code, out, err = command(*asked, *more)
        assert code == 0, err
        texts.append(out)
    return trueaxis.ballbar(file, radius_mm=100, pitch_x_mm=10), texts[0], json.loads(texts[1])


def test_a_result_prints_what_the_command_prints(ballbar):
    found, text, document = ballbar
    assert type(found) is trueaxis.Ballbar and repr(found) == text.rstrip("\n")
    assert found.to_dict() == document and found == document


def test_fields_are_attributes_that_do_not_change(ballbar):
    found, _, document = ballbar
    assert found.squareness_urad == document["squareness_urad"]
    assert found.backlash_um.x == found["backlash_um"]["x"]
    assert np.array_equal(found.centre_um, document["centre_um"]) and not found.centre_um.flags.writeable
    assert found.shares[0].cause == document["shares"][0]["cause"]
    assert found.written is None
    with pytest.raises(AttributeError, match="nothing.*needed one of readings, "):
        found.nothing
    with pytest.raises(AttributeError, match="does not change"):
        found.readings = 3


def test_figures_have_their_uncertainties(ballbar):
    found, _, document = ballbar
    [squareness] = [figure for name, figure in found.figures.items() if name.startswith("squareness")]
    assert squareness.value == document["squareness_urad"] and squareness.unit == "µrad"
    assert squareness.expanded == document["expanded_uncertainties"]["squareness_urad"]
    low, high = squareness.interval()
    assert low < squareness.value < high and high - low == pytest.approx(2 * squareness.expanded)
    number = squareness.to_ufloat()
    assert (number.nominal_value, number.std_dev) == (squareness.value, squareness.u)
    with pytest.raises(ValueError, match="play: found no uncertainty"):
        trueaxis.Figure("play", 3.0, "µm", None).interval()


def test_tables_are_data_frames(ballbar):
    found, _, document = ballbar
    for caption in found.tables:
        frame = found.to_frame(caption)
        assert len(frame) and caption in repr(found)
    values = {value for caption in found.tables for value in found.to_frame(caption).to_numpy().ravel() if isinstance(value, float)}
    assert document["squareness_urad"] in values and document["sigma_um"] in values
    with pytest.raises(KeyError, match="needed an index below"):
        found.to_frame("no table")


def test_plots_are_drawn(ballbar):
    found, _, _ = ballbar
    points = trueaxis.circle(np.column_stack([np.cos(np.arange(9.0)), np.sin(np.arange(9.0))]))
    assert found.plots and not points.plots
    for which in found.plots:
        ax = found.plot(which=which)
        assert ax.get_title() == which and ax.lines
        assert found.plot(ax, which=which) is ax
        plt.close(ax.figure)
    with pytest.raises(KeyError):
        points.plot()


def test_a_notebook_shows_tables_and_figures(ballbar):
    found, _, _ = ballbar
    shown = found._repr_html_()
    assert shown.count("<table>") == len(found.tables) and shown.count("<figure") == len(found.plots)


def test_a_run_a_plan_and_angles_print_their_table():
    run = trueaxis.simulate(trueaxis.Machine.load(TABLES / "mill-3axis"), trueaxis.Program.from_text("G21 G90 F1500\nG1 X1\nM2\n"), rate_hz=1000)
    assert repr(run).startswith("program on mill-3axis: 0.") and run.to_frame().loc["corrected", "largest"] == run.contour_error_um.compensated["max"]
    angles = trueaxis.probe_angles(n=64, count=2)
    code, out, err = command("probe-angles", "--n", "64", "--count", "2")
    assert code == 0, err
    assert repr(angles) == out.rstrip("\n") and "<table>" in angles._repr_html_() and len(angles.to_frame()) == 2


def test_a_result_is_pickled_whole(ballbar):
    found, _, _ = ballbar
    again = pickle.loads(pickle.dumps(found))
    assert type(again) is trueaxis.Ballbar and again == found and repr(again) == repr(found)
    assert again._repr_html_() == found._repr_html_() and again.figures == found.figures


def test_every_field_has_its_type(ballbar):
    """The types state every field of the documents: those of the JSON and those that only Python has."""
    traced = trueaxis.ballbar(record(), radius_mm=100, pitch_x_mm=10, traces=True, machine=trueaxis.Machine.load(TABLES / "mill-3axis"))
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    for found in (traced, trueaxis.accuracy(MEASURED, machine=mill), trueaxis.circle(record()[:, :2]), trueaxis.probe_angles(n=64)):
        typed(found)


def typed(section):
    stated = {name.removesuffix("_") for kind in type(section).__mro__ for name in kind.__dict__.get("__annotations__", ())}
    assert set(section) <= stated, (type(section), set(section) - stated)
    for name in section:
        value = getattr(section, name)
        for of in value if isinstance(value, tuple) else [value]:
            if isinstance(of, trueaxis.Section) and type(of) is not trueaxis.Section:
                typed(of)


def test_the_accuracy_of_an_axis_is_that_of_the_command():
    folder = TABLES / "mill-3axis"
    mill = trueaxis.Machine.load(folder)
    for more, options in (
        ({}, []),
        ({"machine": mill}, ["--machine", folder]),
        ({"instrument": mill, "tolerance_um": 40}, ["--instrument", folder, "--tolerance-um", "40"]),
    ):
        code, out, err = command("tables", "accuracy", MEASURED, *options)
        assert code == 0, err
        found = trueaxis.accuracy(MEASURED, **more)
        assert repr(found) == out.rstrip("\n") and (found.compensated is None) == ("machine" not in more)
        code, out, err = command("tables", "accuracy", MEASURED, *options, "--json")
        assert code == 0, err
        assert found == json.loads(out)
    assert found.verdict.figure == "A" and found.figures["A, bidirectional accuracy"].expanded > 0


def test_the_accuracy_of_a_frame_is_that_of_its_file():
    """As rows, and as the matrix of an instrument: a column for each run and direction."""
    rows = pd.read_csv(MEASURED, comment="#")
    found = trueaxis.accuracy(MEASURED).measured
    assert trueaxis.accuracy(rows).measured == found
    runs = rows.assign(column=rows.direction + rows.run.astype(str))
    matrix = runs.pivot_table(index="X_mm", columns="column", values="deviation_um").reset_index()
    assert trueaxis.accuracy(matrix).measured == found
    assert trueaxis.accuracy({name: matrix[name].to_numpy() for name in matrix}).measured == found
    assert refused(lambda: trueaxis.accuracy({"X_mm": [1, 2], "+1": [3]})).startswith("record: found 1 rows of +1 and 2 of X_mm")
    assert refused(lambda: trueaxis.accuracy(rows.assign(direction="a,b"))).startswith('record: found "a,b"')
    refused(lambda: trueaxis.accuracy(np.zeros((3, 3))), TypeError)


def test_an_accuracy_that_cannot_be_stated_is_refused(tmp_path):
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    for more, needed in (
        ({"axis": "Q"}, "axis: found 'Q', needed X, Y"),
        ({"confidence": 12}, "confidence: found 12, needed 50 to 99.99 %"),
        ({"tolerance_um": 5}, "instrument: found none"),
        ({"tolerance_um": -5, "instrument": mill}, "tolerance_um: found -5"),
    ):
        assert refused(lambda: trueaxis.accuracy(MEASURED, **more)).startswith(needed)
    refused(lambda: trueaxis.accuracy(tmp_path / "nowhere.csv"), FileNotFoundError)
