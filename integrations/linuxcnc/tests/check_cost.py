"""Measures the cost of a call with HAL's own `time` and `tmax`, beside stock components in the same thread."""
import os

import rig
from machines import SAMPLES, compile_tables
from rig import expect

CYCLES = 10000
# Functions whose `time` is sampled in every cycle, in the sampler's order.
FUNCTIONS = ("ta.update-feedback", "ta.update-output", "offset-x.update-feedback", "offset-x.update-output", "pid-x.do-pid-calcs")
COST_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt siggen names=move
loadrt offset names=offset-x,offset-y,offset-z
loadrt pid names=pid-x
loadrt trueaxis names=ta tables=%(tables)s units=mm angular_units=degree
loadrt sampler depth=%(cycles)d cfg=sssss
setp move.frequency 0.5
setp move.amplitude 50
setp move.offset %(offset)g
setp ta.enable 1
net move move.sine => offset-x.in offset-y.in offset-z.in pid-x.command
%(nets)s
%(times)s
addf move.update servo-thread
addf ta.update-feedback servo-thread
addf offset-x.update-feedback servo-thread
addf offset-y.update-feedback servo-thread
addf offset-z.update-feedback servo-thread
addf offset-x.update-output servo-thread
addf offset-y.update-output servo-thread
addf offset-z.update-output servo-thread
addf pid-x.do-pid-calcs servo-thread
addf ta.update-output servo-thread
addf sampler.0 servo-thread
start
loadusr -w sleep 1
%(reset)s
loadusr -w halsampler -n %(cycles)d
%(tmax)s
getp ta.active
getp ta.fault-code
"""


def clock_mhz():
    with open("/proc/cpuinfo") as f:
        rates = [float(line.split(":")[1]) for line in f if line.startswith("cpu MHz")]
    return rates[0] if rates else 1000.0


def one(folder, machine, letters, offset):
    compile_tables(folder, os.path.join(SAMPLES, machine, "machine.toml"), machine + ".tcomp")
    nets = []
    for j, letter in enumerate(letters):
        moving = "net move => ta.joint.%d.pos-cmd ta.joint.%d.motor-pos-cmd-in" % (j, j) if letter in "XYZ" else ""
        nets += ["setp ta.joint.%d.homed 1" % j, moving,
                 "net back-{0} ta.joint.{0}.motor-pos-cmd-out => ta.joint.{0}.motor-pos-fb-in".format(j)]
    text = COST_HAL % {
        "tables": machine + ".tcomp", "cycles": CYCLES, "nets": "\n".join(nets), "offset": offset,
        "times": "\n".join("net t%d %s.time => sampler.0.pin.%d" % (k, of, k) for k, of in enumerate(FUNCTIONS)),
        # Ignores loading and the first cycles.
        "reset": "\n".join("setp %s.tmax 0" % of for of in FUNCTIONS),
        "tmax": "\n".join("getp %s.tmax" % of for of in FUNCTIONS),
    }
    code, printed = rig.halrun(folder, text, 60)
    lines = [line.split() for line in printed.splitlines() if line.count(" ") >= 4 and line[0].isdigit()]
    rows = [[int(word) for word in line] for line in lines]
    expect(code == 0 and len(rows) == CYCLES, "%d samples" % len(rows), printed[-2000:])
    after = [line.strip() for line in printed.splitlines() if line.strip() in ("TRUE", "FALSE") or line.strip().isdigit()]
    expect(len(after) == len(FUNCTIONS) + 2 and after[-2:] == ["TRUE", "0"], "not active, or a fault", printed[-300:])
    found = []
    for column, tmax in zip(zip(*rows[CYCLES // 5 :]), after):
        column = sorted(column)
        expect(int(tmax) >= column[-1], "tmax is %s, a call took %d" % (tmax, column[-1]))
        found.append((column[len(column) // 2], column[len(column) * 999 // 1000], int(tmax)))
    return found


def cost(folder):
    """Reports clocks of the time-stamp counter. Checks only the order of magnitude of the median."""
    mhz = clock_mhz()
    said = ["median, 99.9 %%, tmax in clocks of %.0f MHz" % mhz]
    for machine, letters, offset in (("mill-3axis", "XYZ", -60.0), ("mill-5axis", "XYZAC", 0.0)):
        found = one(folder, machine, letters, offset)
        said.append(machine + ": " + ", ".join("%s %d %d %d" % (of, *clocks) for of, clocks in zip(FUNCTIONS, found)))
        output = found[1][0]
        expect(output / mhz < 100.0, "a call takes %g us" % (output / mhz))
    return "; ".join(said)


TESTS = (cost,)
