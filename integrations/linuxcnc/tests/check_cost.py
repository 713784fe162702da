"""Cost of a call, from HAL's own time pins, beside a stock component in the same thread."""
import os
import statistics

import rig
from machines import SAMPLES, compile_tables
from rig import expect

CYCLES = 4000
COST_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt siggen names=move
loadrt offset names=offset-x,offset-y,offset-z
loadrt pid names=pid-x
loadrt trueaxis names=ta tables=%(tables)s
loadrt sampler depth=%(cycles)d cfg=sssss
setp move.frequency 0.5
setp move.amplitude 50
setp move.offset %(offset)g
setp ta.enable 1
net move move.sine => offset-x.in offset-y.in offset-z.in pid-x.command
%(nets)s
net t0 ta.update-feedback.time => sampler.0.pin.0
net t1 ta.update-output.time => sampler.0.pin.1
net t2 offset-x.update-feedback.time => sampler.0.pin.2
net t3 offset-x.update-output.time => sampler.0.pin.3
net t4 pid-x.do-pid-calcs.time => sampler.0.pin.4
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
loadusr -w halsampler -n %(cycles)d
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
    text = COST_HAL % {"tables": machine + ".tcomp", "cycles": CYCLES, "nets": "\n".join(nets), "offset": offset}
    code, printed = rig.halrun(folder, text, 60)
    lines = [line.split() for line in printed.splitlines() if line.count(" ") >= 4 and line[0].isdigit()]
    rows = [[int(word) for word in line] for line in lines]
    expect(code == 0 and len(rows) == CYCLES, "%d samples" % len(rows), printed[-2000:])
    after = [line.strip() for line in printed.splitlines() if line.strip() in ("TRUE", "FALSE") or line.strip().isdigit()]
    expect(after == ["TRUE", "0"], "not active, or a fault", printed[-300:])
    columns = list(zip(*rows[CYCLES // 4 :]))
    return [statistics.median(column) for column in columns]


def cost(folder):
    """Median of a call in clocks of the time-stamp counter; nothing is gated but the order of magnitude."""
    mhz = clock_mhz()
    said = []
    for machine, letters, offset in (("mill-3axis", "XYZ", -60.0), ("mill-5axis", "XYZAC", 0.0)):
        feedback, output, offset_feedback, offset_output, pid = one(folder, machine, letters, offset)
        said.append("%s: feedback %d, output %d clocks (%.2f us); offset %d + %d, pid %d" % (
            machine, feedback, output, output / mhz, offset_feedback, offset_output, pid))
        expect(output / mhz < 100.0, "a call takes %g us" % (output / mhz))
    return "; ".join(said)


TESTS = (cost,)
