"""Simulations equal `firmware-sim run`'s, bit for bit: figures, digests, traces; both refuse the same input."""

import json
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import trueaxis
from shared import assert_lock_is_released, refused

TABLES = Path(__file__).resolve().parents[3] / "compensation-tables"
SIMULATOR = os.environ["TRUEAXIS_SIMULATOR"]
# Keys with measured times, which differ from run to run.
OF_TIME = ("latency_ns", "budget_ns", "over_budget", "missed_deadlines", "wall_s")
BUSY = "a busy kernel"
SHORT = "G21 G90 G0 X0 Y0\nG1 X20 F3000\nG2 X20 Y20 I0 J10\nG1 Z-2 F600\nS500 M3\nG1 X0\nM2\n"

pytestmark = pytest.mark.filterwarnings("ignore:.*run")


def simulator(*arguments):
    run = subprocess.run([SIMULATOR, "run", *map(str, arguments)], capture_output=True, text=True)
    return run.returncode, run.stdout, run.stderr


def printed(*arguments):
    code, out, err = simulator(*arguments, "--json")
    assert code == 0, err
    document = {name: value for name, value in json.loads(out).items() if name not in OF_TIME}
    document["notes"] = [note for note in document["notes"] if not note.startswith(BUSY)]
    return document


def mill(name="mill-3axis"):
    return trueaxis.Machine.load(TABLES / name)


def short():
    return trueaxis.Program.from_text(SHORT, name="short")


def adapting(folder, share):
    """The mill with 60 % of the Coulomb friction stated, and friction of X and Y that adapts by that share at most."""
    own = folder / f"mill-{share}"
    shutil.copytree(TABLES / "mill-3axis", own)
    text = (own / "machine.toml").read_text()
    for axis, level in (("X", 0.27), ("Y", 0.312)):
        head = f"[axis.{axis}.friction]\n"
        start = text.index(head) + len(head)
        end = text.index("\n", start)
        text = f"{text[:start]}coulomb_mm_per_s = {level}\nadapt = {share}{text[end:]}"
    (own / "machine.toml").write_text(text)
    return trueaxis.Machine.load(own)


CASES = [
    ("mill-3axis", "pocket-3d", {"seed": 7, "rate_hz": 1000.0}, ["--seed", 7, "--rate-hz", 1000]),
    (
        "mill-3axis",
        "pocket-3d",
        {
            "rate_hz": 2000.0,
            "temperature_c": 24.5,
            "model": "volumetric",
            "faults": ["dropout:X@0.25s+3"],
            "events": ["off:friction@0.4s"],
            "settings": {"drive.dead_time_s": 0.001, "axis.Y.lost_motion_mm": 0.002},
        },
        ["--rate-hz", 2000, "--temperature-c", 24.5, "--model", "volumetric", "--fault", "dropout:X@0.25s+3",
         "--event", "off:friction@0.4s", "--dead-time-ms", 1, "--set", "axis.Y.lost_motion_mm=0.002"],
    ),
    (
        "mill-3axis",
        "pocket-3d",
        {"rate_hz": 2000.0, "on_trial": True, "events": ["off:trial@3s"]},
        ["--rate-hz", 2000, "--event", "on:trial@0s", "--event", "off:trial@3s"],
    ),
    ("mill-5axis", "cone-5axis", {"rate_hz": 500.0, "orientation": True}, ["--rate-hz", 500, "--orientation"]),
]


@pytest.mark.parametrize("machine, program, asked, options", CASES)
def test_documents_and_traces_are_those_of_the_simulator(tmp_path, machine, program, asked, options):
    document = printed("--machine", TABLES / machine, "--program", program, *options,
                       "--report", tmp_path, "--trace-every", 7)
    found = trueaxis.simulate(mill(machine), trueaxis.Program.load(program), trace_every=7, **asked).to_dict()
    traces = found.pop("trace")
    assert found == document
    assert traces.keys() == found["digest"].keys()
    for kind, name in (("compensated", "trace.csv"), ("full", "trace-full.csv")):
        header, *rows = (tmp_path / name).read_text().splitlines()
        assert header.split(",") == list(traces[kind])
        for column, values, written in zip(traces[kind], traces[kind].values(), np.array([r.split(",") for r in rows]).T):
            if values.dtype == np.int64:
                assert np.array_equal(values, written.astype(np.int64)), column
            else:
                decimals = len(written[0].rpartition(".")[2])
                assert [f"{value:.{decimals}f}" for value in values] == list(written), column
    if len(asked.get("faults", [])):
        assert found["faults"] and found["faults"][0]["axis"] == "X"


def test_programs_from_texts_and_files_are_the_same(tmp_path):
    (tmp_path / "short.ngc").write_text(SHORT)
    (tmp_path / "scenario.toml").write_text("rate_hz = 1000\n[motion]\nfeed_percent = 80\n")
    document = printed("--machine", TABLES / "mill-3axis", "--program", tmp_path / "short.ngc", "--scenario", tmp_path / "scenario.toml")
    text = (tmp_path / "scenario.toml").read_text()
    for program in (short(), trueaxis.Program.load(tmp_path / "short.ngc")):
        assert (program.name, program.moves) == ("short", 4)
        assert trueaxis.simulate(mill(), program, scenario=text) == document
    assert document["noted"]


def test_a_program_by_its_path_finds_its_subprograms_beside_it(tmp_path):
    (tmp_path / "side.ngc").write_text("o<side> sub\nG1 X#1\no<side> endsub\n")
    text = "G21 G90 F3000\no<side> call [5]\no<side> call [12]\nM2\n"
    (tmp_path / "part.ngc").write_text(text)
    program = trueaxis.Program.load(tmp_path / "part.ngc")
    assert program.moves == 2
    assert trueaxis.simulate(mill(), program, rate_hz=1000.0) == printed("--machine", TABLES / "mill-3axis", "--program", tmp_path / "part.ngc", "--rate-hz", 1000)
    # A text has no folder.
    assert "`O<side> call` without its subprogram" in refused(lambda: trueaxis.Program.from_text(text, name="part"))


def test_seeds_differ_and_machines_may_be_chosen():
    machine, program = mill(), short()
    all_of_them = trueaxis.simulate(machine, program, rate_hz=1000.0)["digest"]
    chosen = trueaxis.simulate(machine, program, rate_hz=1000.0, kinds=["servo_only", "compensated"])["digest"]
    assert chosen == {kind: all_of_them[kind] for kind in ("compensated", "servo_only")}
    other = trueaxis.simulate(machine, program, rate_hz=1000.0, seed=2, kinds=["compensated"])["digest"]
    assert other["compensated"] != chosen["compensated"]


def test_parts_on_trial_and_friction_that_adapts(tmp_path):
    machine = adapting(tmp_path, 0.5)
    turns = trueaxis.Program.from_text("G21 G90 F1500\n" + 4 * "G2 I10\n", name="turns")
    run = lambda machine, **asked: trueaxis.simulate(machine, turns, rate_hz=1000.0, kinds=["full"], trace_every=1, **asked)
    plain, trial = run(machine), run(machine, on_trial=True)
    assert trial["digest"] != plain["digest"]
    # On trial nothing acts before it has shown that it helps. The first cycles still have what the machine rested with.
    first, tried = [found["trace"]["full"]["feed_forward_y_um"][150:] for found in (plain, trial)]
    moves = np.argmax(np.abs(first) > 0.5)
    assert moves > 0 and np.abs(tried[: moves + 1]).max() < 0.05
    # The stated friction is 40 % too low, and is followed.
    factors = plain["friction_factors"]["full"]
    assert list(factors) == ["X", "Y"] and all(factors[axis]["coulomb"] > 1.1 for axis in factors)
    trace = plain["trace"]["full"]
    assert trace["friction_factor_x"][0] == 1.0 and trace["friction_factor_x"][-1] == factors["X"]["coulomb"]
    assert "friction_factor_z" not in trace
    held = run(machine, events=["off:adapt@4s", "reset:adapt@6s", "on:adapt@7s"])["trace"]["full"]["friction_factor_x"]
    assert held[4000] > 1.04 and (held[4000:6000] == held[4000]).all() and (held[6000:7000] == 1.0).all() and held[-1] > 1.0
    frozen, none = run(machine, events=["off:adapt@0s"]), run(adapting(tmp_path, 0.0))
    assert frozen["friction_factors"]["full"]["X"] == {"coulomb": 1.0, "presliding": 1.0}
    assert "friction_factors" not in none
    assert np.array_equal(frozen["trace"]["full"]["drive_x_mm"], none["trace"]["full"]["drive_x_mm"])


def test_tables_are_exchanged_for_those_of_another_machine(tmp_path):
    (tmp_path / "short.ngc").write_text(SHORT)
    other = f"{TABLES}/mill-5axis"
    asked = {"rate_hz": 1000.0, "kinds": ["compensated", "servo_only", "uncompensated"]}
    for name in (f"{TABLES}/mill-3axis", other):
        event = f"exchange:{name}@0.2s"
        code, out, err = simulator("--machine", TABLES / "mill-3axis", "--program", tmp_path / "short.ngc",
                                   "--rate-hz", 1000, "--event", event, "--json")
        call = lambda: trueaxis.simulate(mill(), short(), events=[event], exchanges={name: trueaxis.Machine.load(name)}, **asked)
        if name == other:
            # The other machine has other axes: both refuse its tables.
            assert code == 2 and refused(call) in err
        else:
            digests = json.loads(out)["digest"]
            del digests["full"]
            assert call()["digest"] == digests


def test_the_true_error_of_the_trace_is_the_distance_from_the_line():
    # Along X, the true contour error is the offset in Y and Z; it equals the machine's static error there.
    machine = mill()
    program = trueaxis.Program.from_text("G21 G90 G0 X0 Y0 Z0\nG1 X40 F1200\nM2\n", name="line")
    quiet = {"encoder.linear.noise_rms_mm": 0.0, "drive.coulomb_mm_per_s2": 0.0}
    found = trueaxis.simulate(machine, program, rate_hz=1000.0, settings=quiet, kinds=["uncompensated"], trace_every=1)
    trace = found["trace"]["uncompensated"]
    cut = (trace["line"] == 2) & (trace["command_x_mm"] > trace["command_x_mm"][0] + 5)
    at = np.column_stack([trace[f"feedback_{a}_mm"][cut] for a in "xyz"])
    error = machine.error(at, model="volumetric")
    assert np.abs(error[:, 1:]).max() > 0.5
    measured = np.column_stack([trace[f"true_error_{a}_um"][cut] for a in "yz"])
    assert np.allclose(measured[:-50], error[:-50, 1:], rtol=0, atol=0.2)


def test_simulations_run_side_by_side_with_the_same_bits():
    machine, program = mill(), trueaxis.Program.load("pocket-3d")
    run = lambda seed: trueaxis.simulate(machine, program, rate_hz=2000.0, seed=seed, kinds=["compensated"])["digest"]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, range(4))) == [run(seed) for seed in range(4)]


def test_the_lock_is_released():
    assert_lock_is_released(lambda: trueaxis.simulate(mill(), trueaxis.Program.load("pocket-3d")))


REFUSALS = [
    ({"rate_hz": 5.0}, ["--rate-hz", 5]),
    ({"origin_mm": [0.0, 0.0, 1e5]}, ["--origin-mm", "0,0,1e5"]),
    ({"settings": {"drive.gain": 3}}, ["--set", "drive.gain=3"]),
    ({"faults": ["dropout:X"]}, ["--fault", "dropout:X"]),
    ({"events": ["off:brakes@1s"]}, ["--event", "off:brakes@1s"]),
    ({"model": "nine", "orientation": True}, ["--model", "nine", "--orientation"]),
    ({"learned": "missing.tlearn"}, ["--learned", "missing.tlearn"]),
]


@pytest.mark.parametrize("asked, options", REFUSALS)
def test_refusals_are_in_the_words_of_the_simulator(tmp_path, asked, options):
    (tmp_path / "short.ngc").write_text(SHORT)
    code, out, err = simulator("--machine", TABLES / "mill-3axis", "--program", tmp_path / "short.ngc", *options)
    assert code == 2
    kind = FileNotFoundError if "learned" in asked else trueaxis.Error
    message = refused(lambda: trueaxis.simulate(mill(), short(), **asked), kind)
    # Messages name an argument without the dashes of its flag.
    assert message.removeprefix("rate_hz: ") in err.replace("--learned", "learned")


def test_programs_that_are_refused(tmp_path):
    file = tmp_path / "bad.ngc"
    for text in ("G1 X", "G21 G1 X5", "", "G2 X1 Y1 F100", "G1 X1e9 F100"):
        file.write_text(text)
        code, out, err = simulator("--machine", TABLES / "mill-3axis", "--program", file)
        if code == 2 and f"{file}:" in err:
            assert refused(lambda: trueaxis.Program.load(file)) in err
    assert "needed: a number after X" in refused(lambda: trueaxis.Program.from_text("G1 X"))
    missing = tmp_path / "missing.ngc"
    assert refused(lambda: trueaxis.Program.load(missing), FileNotFoundError) in simulator("--program", missing)[2]
    assert refused(lambda: trueaxis.simulate(mill(), short(), kinds=[])) == "kinds: found none, needed at least one"
    assert refused(lambda: trueaxis.simulate(mill(), short(), trace_every=0)) == "trace_every: found 0, needed at least 1"
    assert "no machine of that name" in refused(lambda: trueaxis.simulate(mill(), short(), events=["exchange:a@1s"]))
