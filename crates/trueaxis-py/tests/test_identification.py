"""Errors of rotary axes and friction, compared with the command line and with the errors in generated measurements."""

import json
import math

import numpy as np
import pytest

import trueaxis
from shared import assert_lock_is_released, refused
from test_command_line import TABLES, command, written

BALLS = [(150.0, 40.0), (260.0, 40.0), (150.0, 120.0), (210.0, 90.0)]
HEADER = "angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um"


def readings(noise_um):
    """Readings of a C axis with known errors e and w: e + w × p, the ball at p = (−H sin C, H cos C, −L)."""
    noise, rows, truth = np.random.default_rng(11), [], []
    for angle in np.arange(0.0, 360.0, 30.0):
        t = math.radians(angle)
        shift = np.array([3 * math.cos(t), 2 * math.sin(2 * t), 1.5 * math.sin(t)])
        turn = np.array([20 * math.sin(t), 15 * math.cos(t), 40 * math.sin(3 * t)])
        truth.append([*shift, *turn])
        for low, side in BALLS:
            ball = np.array([-side * math.sin(t), side * math.cos(t), -low])
            moved = shift + np.cross(1e-3 * turn, ball) + noise.normal(0, noise_um, 3)
            rows.append([angle, low, side, *moved])
    return np.array(rows), np.array(truth)


def test_errors_are_those_of_identify(tmp_path):
    rows, truth = readings(0.05)
    file = written(tmp_path / "ball.csv", HEADER, rows)
    code, out, err = command("identify", file, "--axis", "C", "--json", "-o", tmp_path / "c.csv")
    assert code == 0, err
    found = trueaxis.identify(rows, axis="C", table=True).to_dict()
    assert found.pop("table") == (tmp_path / "c.csv").read_text()
    assert found == json.loads(out)
    names = ["exc_um", "eyc_um", "ezc_um", "eac_urad", "ebc_urad", "ecc_urad"]
    off = np.array([[at[name] for name in names] for at in found["angles"]]) - truth
    spread = np.array([found["standard_errors"][name] for name in names])
    assert found["sigma_um"] == pytest.approx(0.05, rel=0.3)
    assert np.all(np.sqrt(np.mean(off**2, axis=0)) < 2 * spread) and spread.max() < 2
    found = trueaxis.identify(file, axis="C", table=True)
    assert found["table"] == (tmp_path / "c.csv").read_text()


def test_an_angle_has_the_covariance_of_its_equations():
    """Against σ² (AᵀA)⁻¹ with the rows of e + w × p, written here; residuals against NumPy's least squares of these rows."""
    data = readings(0.05)[0]
    found = trueaxis.identify(data, axis="C", residuals=True)
    read, left = data[:, 3:].reshape(-1, 12), found.residuals_um.reshape(-1, 12)
    for k, angle in enumerate(found.angles[:4]):
        t, rows = math.radians(angle.angle_deg), []
        for low, side in BALLS:
            x, y, z = -side * math.sin(t), side * math.cos(t), -low
            rows += [[1, 0, 0, 0, 1e-3 * z, -1e-3 * y], [0, 1, 0, -1e-3 * z, 0, 1e-3 * x], [0, 0, 1, 1e-3 * y, -1e-3 * x, 0]]
        fitted = np.array(rows) @ np.linalg.lstsq(np.array(rows), read[k], rcond=None)[0]
        assert np.allclose(left[k], read[k] - fitted, rtol=0, atol=1e-9)
        needed = found.sigma_um**2 * np.linalg.inv(np.transpose(rows) @ rows)
        errors = np.sqrt(np.diag(needed))
        assert np.allclose(np.array(angle.covariance.matrix), needed, rtol=0, atol=1e-9 * np.outer(errors, errors))
        assert np.allclose(angle.correlation, needed / np.outer(errors, errors))
        numbers = angle.to_ufloats()
        assert [number.std_dev for number in numbers.values()] == pytest.approx([angle.standard_errors[name] for name in numbers])
        assert numbers["exc_um"].nominal_value == angle.exc_um
    free = trueaxis.identify(data, axis="C", free_offsets=True, residuals=True)
    # An offset is fitted for every set-up, so its residuals have no mean.
    assert np.allclose(free.residuals_um.reshape(-1, 4, 3).mean(axis=0), 0, atol=1e-9) and np.std(free.residuals_um) < 0.06
    with pytest.raises(ValueError, match="an angle of identify"):
        found.to_ufloats()


def test_linear_axes_of_a_machine_are_removed(tmp_path):
    rows, _ = readings(0.0)
    file = written(tmp_path / "ball.csv", HEADER, rows)
    machine = trueaxis.Machine.load(TABLES / "mill-5axis")
    options = ["--machine", TABLES / "mill-5axis", "--start-mm", "10,20,-150", "--free-offsets"]
    code, out, err = command("identify", file, "--axis", "C", "--json", *options, "--dry-run")
    assert code == 0, err
    found = trueaxis.identify(rows, axis="C", machine=machine, start_mm=[10, 20, -150], free_offsets=True)
    assert found == json.loads(out)
    assert [of["key"] for of in found["written"]][0] == "axis.C.EXC_um" and len(found["written"]) == 6
    assert found["angles"] != trueaxis.identify(rows, axis="C", free_offsets=True)["angles"]


def test_refusals_of_identify():
    rows, _ = readings(0.0)
    mill = trueaxis.Machine.load(TABLES / "mill-3axis")
    assert refused(lambda: trueaxis.identify(rows, axis="X")).startswith('axis: found "X"')
    assert refused(lambda: trueaxis.identify(rows[:, :5].copy(), axis="C")).startswith("readings: found shape (48, 5)")
    assert refused(lambda: trueaxis.identify(rows[::4].copy(), axis="C")).startswith("readings: columns l_mm, h_mm: found 1 set-up")
    twice = np.vstack([rows, rows[5]])
    assert refused(lambda: trueaxis.identify(twice, axis="C")).startswith("readings:50: column angle_deg: found a second row")
    assert refused(lambda: trueaxis.identify(rows, axis="C", machine=mill)).endswith("needed the axis that was measured")
    assert refused(lambda: trueaxis.identify(rows, axis="C", start_mm=[0, 0, 0])).startswith("start_mm: found no machine")
    assert refused(lambda: trueaxis.identify("nowhere.csv", axis="C"), FileNotFoundError).startswith("cannot read nowhere.csv")


# The drives that generate the record, and the figures that the function must find.
PERIOD_S, COULOMB, SHARE, PRESLIDING = 5e-4, 0.5, 0.3, 0.006
DRIVE = "position_gain_per_s = 110\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\nvelocity_feed_forward = 0.93\n"
MACHINE = f"""name = "m"
chain = "w X' Y' b Z t"
[axis.X]
table = "x.csv"
travel_mm = [-100, 100]
[axis.X.drive]
{DRIVE}[axis.Y]
travel_mm = [-100, 100]
[axis.Y.drive]
{DRIVE}"""


def commands(feeds):
    """Commands of circles of 15.004 mm from rest to rest; positive feeds, mm/s, are counterclockwise."""
    radius, ramp, angle, turns = 15.004, 0.05, 0.4, []
    for feed in feeds:
        duration = 1.5 * math.tau * radius / abs(feed) + ramp
        t = np.maximum(np.arange(int((duration + 0.1) / PERIOD_S)) * PERIOD_S - 0.1, 0.0)
        edge = np.clip(np.minimum(t, duration - t) / ramp, 0.0, 1.0)
        turns.append(angle + np.cumsum(feed / radius * PERIOD_S * np.sin(0.25 * math.tau * edge) ** 2))
        angle = turns[-1][-1]
    turned = np.concatenate(turns)
    return radius * np.cos(turned), radius * np.sin(turned)


def read(command):
    """Encoder readings in counts of 10 nm; the integration is explicit with steps of 20 µs."""
    h, steps = 2e-5, 25
    x, v, q, m, f = command[0], 0.0, 0.0, 0.0, 0.0
    out = [x]
    for now, then in zip(command[:-1].tolist(), command[1:].tolist()):
        rate = (then - now) / PERIOD_S
        for i in range(steps):
            r = 110.0 * (now + rate * h * (i + 0.5) - x) + 0.93 * rate
            q += h * (r - v) / 0.006
            m += h * (800.0 * (r - v + q) - m) / 2.5e-4
            f += h * (v - abs(v) * f) / PRESLIDING
            v += h * (m - 800.0 * COULOMB * (1.0 + SHARE / (1.0 + v * v / 4.0)) * f)
            x += h * v
        out.append(round(x / 1e-5) * 1e-5)
    return np.array(out)


@pytest.fixture(scope="module")
def record():
    x, y = commands([40.0, -40.0, 15.0, -15.0])
    return np.column_stack([np.arange(len(x)) * PERIOD_S, x, read(x), y, read(y)])


def test_friction_is_that_of_the_command(tmp_path, record):
    (tmp_path / "x.csv").write_text("X_mm,EXX_um\n-100,0\n0,1\n100,0\n")
    (tmp_path / "machine.toml").write_text(MACHINE)
    file = written(tmp_path / "record.csv", "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm", record)
    machine = trueaxis.Machine.load(tmp_path)
    code, out, err = command("friction", file, "--axes", "X,Y", "--machine", tmp_path, "--json", "-o", tmp_path / "f.toml")
    assert code == 0, err
    found = trueaxis.friction(record, axes="X,Y", machine=machine).to_dict()
    decided = found.pop("written")
    assert found == json.loads(out)
    code, out, err = command("friction", file, "--axes", "X,Y", "--machine", tmp_path, "--json", "--dry-run")
    assert code == 0, err
    assert decided == json.loads(out)["written"]
    assert all(of["written"] and of["why"] == "nothing is stated" for of in decided if "coulomb" in of["key"])
    fitted = trueaxis.friction(record, axes="X,Y", machine=machine)
    numbers = fitted.to_ufloats()
    for axis in fitted.axes:
        coulomb = numbers[f"{axis.axis}.coulomb_mm_per_s"]
        assert coulomb.nominal_value == axis.friction.coulomb_mm_per_s
        assert coulomb.std_dev == pytest.approx(axis.standard_errors.coulomb_mm_per_s)
    half = len(fitted.covariance.names) // 2
    assert np.abs(fitted.correlation[:half, :half] - np.eye(half)).max() > 0.5 and not fitted.correlation[half:, :half].any()
    for axis in found["axes"]:
        assert axis["friction"]["coulomb_mm_per_s"] == pytest.approx(COULOMB, rel=0.03)
        assert axis["friction"]["presliding_um"] == pytest.approx(1e3 * PRESLIDING, rel=0.03)
    assert refused(lambda: trueaxis.friction(file, axes="X,Y", read_after_us=1e6)).startswith("read_after_us: found 1000000 µs")
    assert trueaxis.friction(file, axes="X,Y", machine=machine, toml=True)["toml"] == (tmp_path / "f.toml").read_text()
    assert_lock_is_released(lambda: trueaxis.friction(record, axes="X,Y", machine=machine))
    assert all(axis["resonance"] is None and axis["resonance_not_found"] is None for axis in found["axes"])
    fit = trueaxis.friction(record, axes="X,Y", machine=machine, residuals=True)
    assert fit.residuals_um.shape == (len(fit.residuals_t_s), 2) and fit.residuals_t_s[-1] == pytest.approx(record[-1, 0], abs=1e-3)
    # Far below the lag that friction causes at reversals, µm: COULOMB over the position gain.
    assert np.std(fit.residuals_um, axis=0) == pytest.approx(np.zeros(2), abs=0.02 * 1e3 * COULOMB / 110)
    searched = trueaxis.friction(record, axes="X,Y", machine=machine, find_resonance=True)
    assert all(axis.resonance is not None or "needed" in axis.resonance_not_found for axis in searched.axes)


def test_refusals_of_friction(record):
    assert refused(lambda: trueaxis.friction(record, axes="X,X")).startswith('axes: found "X,X"')
    gap = np.delete(record, 700, axis=0)
    assert refused(lambda: trueaxis.friction(gap, axes="X,Y")).startswith("record:702: column t_s: found 0.001000 s after")
    still = record.copy()
    still[:, 1:] = 1.0
    assert refused(lambda: trueaxis.friction(still, axes="X,Y")).startswith("record: ")


def test_a_machine_without_files_decides_nothing(tmp_path):
    rows, _ = readings(0.05)
    code, _, err = command("tables", "compile", TABLES / "mill-5axis", "-o", tmp_path / "m.tcomp")
    assert code == 0, err
    assert "written" not in trueaxis.identify(rows, axis="C", machine=trueaxis.Machine.load(tmp_path / "m.tcomp"))
    assert "written" not in trueaxis.identify(rows, axis="C")
