"""Units: columns and quantities in other units give the figures of those in the functions' own, and a contradiction is refused."""

import numpy as np
import pandas as pd
import pint
import polars
import pytest

import trueaxis
from shared import refused
from test_command_line import TABLES

UNITS = pint.UnitRegistry()
MM = pd.DataFrame({"x_mm": [20.5, 120.0], "y_mm": [10.0, -40.0], "z_mm": [-200.0, -200.0]})
SECTION = np.column_stack([np.cos(np.arange(9.0)), np.sin(np.arange(9.0)) + 0.001 * np.arange(9.0)])


@pytest.fixture(scope="module")
def mill():
    return trueaxis.Machine.load(TABLES / "mill-3axis")


def stated(frame, units):
    frame = frame.copy()
    frame.attrs["units"] = units
    return frame


def test_a_column_may_state_another_unit_in_its_name(mill):
    needed = mill.error(MM)
    for frame in (
        pd.DataFrame({"x_um": 1e3 * MM.x_mm, "y_m": 1e-3 * MM.y_mm, "z_in": MM.z_mm / 25.4, "note": ["a", "b"]}),
        polars.DataFrame({"x_cm": 0.1 * MM.x_mm.to_numpy(), "y_mm": MM.y_mm.to_numpy(), "z_nm": 1e6 * MM.z_mm.to_numpy()}),
        {"x_um": 1e3 * MM.x_mm.to_numpy(), "y_mm": MM.y_mm.to_numpy(), "z_mm": MM.z_mm.to_numpy()},
    ):
        assert mill.error(frame) == pytest.approx(needed, abs=1e-9)


def test_attrs_state_the_unit_of_columns_and_of_a_frame(mill):
    needed = mill.error(MM)
    bare = MM.rename(columns=lambda name: name[0])
    assert np.array_equal(mill.error(stated(bare, "mm")), needed)
    assert mill.error(stated(1e3 * bare, "um")) == pytest.approx(needed, abs=1e-9)
    mixed = stated(bare.assign(x=bare.x / 25.4), {"x": "in", "y": "mm", "z": "mm"})
    assert mill.error(mixed) == pytest.approx(needed, abs=1e-9)
    assert np.array_equal(mill.error(stated(MM, {"x_mm": "mm"})), needed)


def test_quantities_are_converted(mill):
    needed = mill.error(MM)
    assert mill.error(MM.to_numpy() * 1e3 * UNITS.um) == pytest.approx(needed, abs=1e-9)
    assert mill.error(dict(zip(MM, MM.to_numpy().T * UNITS.mm))) == pytest.approx(needed, abs=1e-9)
    by_column = {"x": 0.1 * MM.x_mm.to_numpy() * UNITS.cm, "y": MM.y_mm.to_numpy() * UNITS.mm, "z": MM.z_mm.to_numpy() * UNITS.mm}
    assert mill.error(by_column) == pytest.approx(needed, abs=1e-9)
    circle = trueaxis.circle(SECTION)
    assert trueaxis.circle(SECTION / 25.4 * UNITS.inch).mcc.radius_mm == pytest.approx(circle.mcc.radius_mm)
    radius = 25 + 0.001 * np.cos(3 * np.arange(0, 2 * np.pi, np.pi / 90))
    needed = trueaxis.trace_roundness(radius, upr=15).lsc.zone_um
    turn = np.arange(180) * (2 * np.pi / 180) * UNITS.rad
    assert trueaxis.trace_roundness(radius * UNITS.mm, upr=15).lsc.zone_um == needed
    assert trueaxis.trace_roundness(radius * UNITS.mm, theta_deg=turn).lsc.zone_um > needed


def test_a_record_is_converted_too():
    angle = np.radians(np.arange(0.5, 360, 1.0))
    record = {"angle_deg": np.degrees(angle), "deviation_um": 3 * np.sin(2 * angle) + 0.05 * np.cos(31 * angle), "direction": np.ones(360)}
    found = trueaxis.ballbar(pd.DataFrame(record), radius_mm=100)
    again = pd.DataFrame({"angle_rad": angle, "deviation_mm": 1e-3 * record["deviation_um"], "direction": 1})
    assert trueaxis.ballbar(again, radius_mm=100).squareness_urad == pytest.approx(found.squareness_urad, rel=1e-9)


def test_an_unknown_or_contradictory_unit_is_refused(mill):
    bare = MM.rename(columns=lambda name: name[0])
    for frame, needed in (
        (stated(bare, "furlong"), "column x: found unit 'furlong', needed mm"),
        (stated(bare, "deg"), "column x: found deg, needed mm"),
        (stated(MM, "um"), "column x_mm: found mm in its name and um in attrs, needed one unit"),
        (MM.assign(x_um=1.0).drop(columns="x_mm").assign(x_m=1.0), "columns x_um and x_m: found both, needed one of them, for x_mm"),
        (MM.to_numpy() * UNITS.second, "positions: found second, needed mm"),
        ({"x_mm": MM.x_mm.to_numpy() * UNITS.kelvin}, "column x_mm: found kelvin, needed mm"),
        (bare, "positions: found columns x, y, z, needed x_mm, y_mm, z_mm"),
    ):
        assert refused(lambda: mill.error(frame), ValueError) == needed
