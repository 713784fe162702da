"""Tests files, parameters and streams, without a machine around the component."""
import math
import os
import re

import rig
from machines import SAMPLES, compile_tables, compile_thermal, edited_tables, geometry_alone
from rig import expect

STREAM_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt streamer depth=4000 cfg=fff
loadrt trueaxis names=ta tables=stream.tcomp joints=XYZ %s
loadrt sampler depth=4000 cfg=ffff
setp ta.enable 1
setp ta.joint.0.homed 1
setp ta.joint.1.homed 1
setp ta.joint.2.homed 1
net x streamer.0.pin.0 => ta.joint.0.pos-cmd
net x-motor streamer.0.pin.1 => ta.joint.0.motor-pos-cmd-in
net z streamer.0.pin.2 => ta.joint.2.pos-cmd ta.joint.2.motor-pos-cmd-in
net x-out ta.joint.0.motor-pos-cmd-out => ta.joint.0.motor-pos-fb-in sampler.0.pin.0
net x-back ta.joint.0.motor-pos-fb-out => sampler.0.pin.1
net z-out ta.joint.2.motor-pos-cmd-out => ta.joint.2.motor-pos-fb-in sampler.0.pin.2
net x-correction ta.x.correction => sampler.0.pin.3
addf ta.update-feedback servo-thread
addf streamer.0 servo-thread
addf ta.update-output servo-thread
addf sampler.0 servo-thread
loadusr -w halstreamer stream.in
start
loadusr -w halsampler -n %d
"""


def stream(folder):
    """Compares streamer -> component -> sampler with the tables' straight lines in closed form."""
    compile_tables(folder, os.path.join(rig.MACHINES, "stream", "machine.toml"), "stream.tcomp")
    stated = (("units=mm", 1.0), ("inch=0", 1.0), ("units=INCH", 25.4), ("inch=1", 25.4), ("units=0.0393700787 inch=1", 25.4))
    return "%d samples exact to the sixth decimal, in mm and in inches" % sum(
        streamed(folder, words, unit) for words, unit in stated)


def streamed(folder, words, unit):
    home = 37.0
    way = [0.125 * n for n in range(801)] + [100.0] * 20 + [100.0 - 0.125 * n for n in range(1, 1601)]
    with open(os.path.join(folder, "stream.in"), "w") as f:
        for x in way:
            f.write("%r %r %r\n" % (x / unit, (x + home) / unit, 0.0))
    code, printed = rig.halrun(folder, STREAM_HAL % (words, len(way)))
    expect(code == 0, "halrun", printed)
    expected, before = [], None
    for x in way:
        # The tool is commanded to x, so y + 1e-4 y = x, and Z is off by 5e-5 y. The first cycle passes the command.
        y = x / 1.0001 if before is not None else x
        z = -5e-5 * y if before is not None else 0.0
        back = before + home if before is not None else 0.0
        expected.append([value / unit for value in (y + home, back, z, y - x)])
        before = x
    sampled = [line.split() for line in printed.splitlines() if line.count(" ") >= 3 and line[0] in "-0123456789"]
    expect(len(sampled) == len(way), "%d samples of %d" % (len(sampled), len(way)), printed[:2000])
    for n, (got, wanted) in enumerate(zip(sampled, expected)):
        # halsampler prints six decimals. The inverse starts from the correction sent last, and the first cycle has
        # none: 1e-4 of the difference remains.
        expect(all(abs(float(g) - w) <= 0.5e-6 + 4e-9 for g, w in zip(got, wanted)), "sample %d" % n, got, wanted)
    return len(sampled)


GAUGE_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt streamer depth=16000 cfg=sbfffffff
loadrt trueaxis names=ta tables=gauge.tcomp joints=XZ units=mm
loadrt sampler depth=16000 cfg=fuuuffffb
setp ta.enable 1
setp ta.joint.0.homed 1
setp ta.joint.1.homed 1
net counts streamer.0.pin.0 => ta.gauge.spindle-counts ta.gauge.index-counts
net index streamer.0.pin.1 => ta.gauge.index
net probe-1 streamer.0.pin.2 => ta.gauge.probe-1
net probe-2 streamer.0.pin.3 => ta.gauge.probe-2
net probe-3 streamer.0.pin.4 => ta.gauge.probe-3
net roundness ta.gauge.roundness => sampler.0.pin.0
net evaluated ta.gauge.evaluated => sampler.0.pin.1
net flags ta.gauge.flags => sampler.0.pin.2
net of ta.gauge.revolution-flags => sampler.0.pin.3
net drive ta.joint.0.motor-pos-cmd-out => sampler.0.pin.4
net x-command streamer.0.pin.5 => ta.joint.0.pos-cmd ta.joint.0.motor-pos-cmd-in
net z-command streamer.0.pin.6 => ta.joint.1.pos-cmd ta.joint.1.motor-pos-cmd-in
net x-encoder streamer.0.pin.7 => ta.joint.0.motor-pos-fb-in
net z-encoder streamer.0.pin.8 => ta.joint.1.motor-pos-fb-in
net encoder-error ta.contour.encoder.error => sampler.0.pin.5
net tip-error ta.contour.tip.error => sampler.0.pin.6
net lag ta.contour.tip.lag => sampler.0.pin.7
net found ta.contour.tip.found => sampler.0.pin.8
addf ta.update-feedback servo-thread
addf streamer.0 servo-thread
addf ta.update-output servo-thread
addf sampler.0 servo-thread
loadusr -w halstreamer stream.in
start
loadusr -w halsampler -n %d
"""


def gauge(folder):
    """Three probes about a turning shaft, the slides on a circle: roundness and contour error in the same cycles."""
    compile_tables(folder, os.path.join(rig.MACHINES, "gauge", "machine.toml"), "gauge.tcomp")
    turn, cycles, step = 16384, 6000, 12

    def profile(angle):
        return 2.0 * math.cos(3 * angle) + 0.7 * math.sin(7 * angle)

    # A circle of X and Z at 25 mm/s after a second at rest. The slides lag by 4 ms and cut inwards by 3 um.
    radius, inwards, lag = 20.0, 0.003, 4

    def on_circle(n, r):
        angle = max(n - 1000, 0) * 0.025 / radius
        return r * math.cos(angle), r * math.sin(angle)

    def at(n):
        return on_circle(n, radius)

    def encoder(n):
        return on_circle(n - lag, radius - inwards if n > 1000 + lag else radius)

    with open(os.path.join(folder, "stream.in"), "w") as f:
        for n in range(cycles):
            count = step * n
            theta = 2.0 * math.pi * count / turn
            index = count % turn < step and n > 0
            # The centre orbits by 8 um and wobbles; neither is roundness.
            x, y = 8.0 * math.sin(theta), 8.0 * math.cos(theta) + 3.0 * math.sin(2.3 * theta)
            probes = []
            for slot in (0, 94, 94 + 333):
                phi = 2.0 * math.pi * slot / 512
                probes.append(profile(theta + phi) + y * math.cos(phi) + x * math.sin(phi))
            command, reading = at(n), encoder(n)
            f.write("%d %d %r %r %r %r %r %r %r\n" % (count, index, *probes, *command, *reading))
    code, printed = rig.halrun(folder, GAUGE_HAL % cycles, 60)
    expect(code == 0, "halrun", printed)
    rows = [line.split() for line in printed.splitlines() if line.count(" ") >= 4 and line[0] in "-0123456789"]
    expect(len(rows) == cycles, "%d samples of %d" % (len(rows), cycles), printed[:2000])
    roundness, evaluated = float(rows[-1][0]), int(rows[-1][1])
    # Gaussian filter at 50 undulations per revolution: the transmission of harmonic k is exp(-pi (0.4697 k / 50)^2).
    through = {k: math.exp(-math.pi * (math.sqrt(math.log(2) / math.pi) * k / 50) ** 2) for k in (3, 7)}
    fine = [2.0 * math.pi * i / 512 for i in range(512)]
    filtered = [2.0 * through[3] * math.cos(3 * a) + 0.7 * through[7] * math.sin(7 * a) for a in fine]
    truth = max(filtered) - min(filtered)
    expect(evaluated >= 2, "only %d revolutions" % evaluated, rows[-1])
    expect(abs(roundness - truth) < 0.01, "roundness %g um, the shaft has %g" % (roundness, truth))
    expect(int(rows[-1][3]) == 0, "flags of the revolution", rows[-1])
    worst = 0.0
    for n in range(1200, cycles):
        # Feedback is read before the stream advances, so the reading is that of the previous cycle.
        x, z = encoder(n - 1)
        # Errors in the tables: 0.02 um per mm of X.
        tip = abs(math.hypot(1.00002 * x, z) - radius)
        expect(int(rows[n][8]) == 1, "no contour error in sample %d" % n, rows[n])
        worst = max(worst, abs(float(rows[n][5]) - inwards), abs(float(rows[n][6]) - tip))
        expect(abs(float(rows[n][7]) - 0.025 * (lag + 1)) < 1e-3, "lag in sample %d" % n, rows[n])
    expect(worst < 2e-6, "contour error %g mm from the truth" % worst)
    return "%.3f um after %d revolutions, the shaft has %.3f; contour error within %.0e mm of the truth" % (
        roundness, evaluated, truth, worst)


PAIR_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt trueaxis names=left,right tables=stream.tcomp,gantry.tcomp joints=XYZ,XYYZ joint_tables=right:1=side.tcomp units=mm
addf left.update-feedback servo-thread
addf right.update-feedback servo-thread
addf left.update-output servo-thread
addf right.update-output servo-thread
%s
start
loadusr -w sleep 1.5
getp left.x.correction
getp right.x.correction
getp right.joint.1.correction
getp right.joint.2.correction
getp left.machine-id
getp right.machine-id
stop
unloadrt trueaxis
loadrt trueaxis count=2 tables=stream.tcomp,gantry.tcomp units=mm
show funct
"""


def instances(folder):
    """Two machines in one component have separate tables, joints and states."""
    for name in ("stream", "gantry"):
        compile_tables(folder, os.path.join(rig.MACHINES, name, "machine.toml"), name + ".tcomp")
    compile_tables(folder, os.path.join(rig.MACHINES, "gantry", "left.toml"), "side.tcomp")
    setting = ["setp %s.enable 1" % name for name in ("left", "right")]
    for name, count in (("left", 3), ("right", 4)):
        for j in range(count):
            setting.append("setp %s.joint.%d.homed 1" % (name, j))
            for pin in ("pos-cmd", "motor-pos-cmd-in", "motor-pos-fb-in"):
                setting.append("setp %s.joint.%d.%s 100" % (name, j, pin) if j < 3 else "")
    code, printed = rig.halrun(folder, PAIR_HAL % "\n".join(setting))
    expect(code == 0, "halrun", printed)
    values = [line.strip() for line in printed.splitlines() if line.strip()[:1] in "-0123456789"]
    left, right, one, two = (float(value) for value in values[:4])
    expect(abs(left + 100.0 - 100.0 / 1.0001) < 1e-9, "left: %g" % left)
    expect(right != left and abs(one - two) > 1e-3, "right: %g, joints %g, %g" % (right, one, two))
    expect(values[4] != values[5], "one machine for both", values)
    expect("trueaxis.1.update-output" in printed, "unloaded and loaded again with count=2", printed)
    return "left %.6f, right %.6f and %.6f mm" % (left, one, two)


STOP_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt streamer depth=4000 cfg=fb
loadrt trueaxis names=ta tables=gantry.tcomp joints=XYYZ joint_tables=1=short.tcomp units=mm
loadrt sampler depth=4000 cfg=ffubf
setp ta.enable 1
setp ta.joint.0.homed 1
setp ta.joint.1.homed 1
setp ta.joint.2.homed 1
setp ta.joint.3.homed 1
net y streamer.0.pin.0 => ta.joint.1.pos-cmd ta.joint.1.motor-pos-cmd-in ta.joint.2.pos-cmd ta.joint.2.motor-pos-cmd-in
net reset streamer.0.pin.1 => ta.reset
net left ta.joint.1.motor-pos-cmd-out => ta.joint.1.motor-pos-fb-in sampler.0.pin.0
net right ta.joint.2.motor-pos-cmd-out => ta.joint.2.motor-pos-fb-in sampler.0.pin.1
net code ta.fault-code => sampler.0.pin.2
net stop ta.stop-request => sampler.0.pin.3
net y => sampler.0.pin.4
addf ta.update-feedback servo-thread
addf streamer.0 servo-thread
addf ta.update-output servo-thread
addf sampler.0 servo-thread
loadusr -w halstreamer stream.in
start
loadusr -w halsampler -n %d
"""


def joint_stop(folder):
    """One joint of a gantry leaves the travel of its own table: both joints hold, and both continue together after a reset."""
    machine = os.path.join(rig.MACHINES, "gantry")
    compile_tables(folder, os.path.join(machine, "machine.toml"), "gantry.tcomp")
    edited_tables(folder, machine, "short", lambda text: text.replace("-200.0, 200.0", "-20.0, 20.0"), None, "left.toml")
    out = [0.02 * n for n in range(1201)]
    way = [(y, 0) for y in out] + [(20.0, 0)] * 50 + [(20.0, 1)] * 50 + [(20.0 - 0.02 * n, 0) for n in range(1, 301)]
    with open(os.path.join(folder, "stream.in"), "w") as f:
        f.writelines("%r %d\n" % row for row in way)
    code, printed = rig.halrun(folder, STOP_HAL % len(way))
    rows = [line.split() for line in printed.splitlines() if line.count(" ") >= 4 and line[0] in "-0123456789"]
    expect(code == 0 and len(rows) == len(way), "%d samples" % len(rows), printed[:2000])
    stopped = [n for n, row in enumerate(rows) if row[3] == "1"]
    expect(stopped and stopped == list(range(stopped[0], stopped[-1] + 1)), "not one stop", stopped[:3], stopped[-3:])
    first, over = stopped[0], stopped[-1] + 1
    expect(abs(float(rows[first][4]) - 20.02) < 1e-9 and rows[first][2] == "17", "stop for another reason", rows[first])
    expect(over == len(out) + 50, "released in cycle %d" % over)
    for side in (0, 1):
        held = {row[side] for row in rows[first - 1 : over]}
        expect(len(held) == 1, "side %d moved while held" % side, held)
        changes = [abs(float(b[side]) - float(a[side])) for a, b in zip(rows, rows[1:])]
        expect(max(changes) < 0.05, "side %d jumped by %g mm" % (side, max(changes)))
    expect(all(row[2] == "0" for row in rows[over:]), "faults after the reset", rows[over:][:3])
    return "held for %d cycles" % (over - first)


WARM_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt trueaxis names=ta tables=mill.tcomp units=mm
setp ta.enable 1
setp ta.joint.0.homed 1
setp ta.joint.1.homed 1
setp ta.joint.2.homed 1
setp ta.joint.0.pos-cmd 100
setp ta.joint.0.motor-pos-cmd-in 100
setp ta.joint.0.motor-pos-fb-in 100
addf ta.update-feedback servo-thread
addf ta.update-output servo-thread
start
loadusr -w sleep 0.8
getp ta.x.correction
setp ta.x.temperature-rise 10
loadusr -w sleep 0.8
getp ta.x.correction
setp ta.x.temperature-rise nan
setp ta.reload 1
loadusr -w sleep 0.8
getp ta.x.correction
getp ta.reloads
"""


def warm(folder):
    """An axis that grows by 11.5 um/(m K) is 10 K warmer; new tables are reported, a broken sensor changes nothing."""
    # The encoder does not move, whatever the drive does, so contour feedback would run to its limit.
    edited_tables(folder, os.path.join(SAMPLES, "mill-3axis"), "mill", geometry_alone, None)
    code, printed = rig.halrun(folder, WARM_HAL)
    values = [float(line) for line in printed.splitlines() if line.strip()[:1] in list("-0123456789")]
    expect(code == 0 and len(values) == 4 and values[3] == 1, "halrun", printed)
    grown = values[1] - values[0]
    # The correction of the growth moves the drive back, and so takes up the lost motion.
    with open(os.path.join(SAMPLES, "mill-3axis", "x.csv")) as f:
        forward, reverse = next(line.split(",")[1:3] for line in f if line.startswith("100,"))
    play = 1e-3 * (float(reverse) - float(forward))
    expect(abs(grown + 11.5e-6 * 10 * 100 + play) < 1e-6, "correction changed by %g mm" % grown)
    expect(values[2] == values[1], "after the reload", values)
    return "correction %.5f mm cold, %.5f mm warm" % (values[0], values[1])


THERMAL_TOML = """reference_temperature_c = 20.0
[[sensor]]
name = "nose"
knots_c = [20.0, 30.0]
[axis.X]
datum_mm = 0.0
[axis.X.sensor.nose]
offset_um = [0.0, 10.0]
slope_um_per_m = [0.0, 20.0]
"""

THERMAL_HAL = WARM_HAL.split("loadusr")[0].replace("mill.tcomp", "mill.tcomp thermal=mill.ttherm").replace("start\n", """\
setp ta.thermal.sensor-1 20
start
loadusr -w sleep 3.5
getp ta.x.correction
setp ta.thermal.sensor-1 22
loadusr -w sleep 1.8
getp ta.x.correction
setp ta.thermal.sensor-1 80
loadusr -w sleep 1.8
getp ta.x.correction
getp ta.thermal.sensor-1-status
setp ta.thermal.sensor-1 nan
loadusr -w sleep 1.8
getp ta.x.correction
getp ta.thermal.sensor-1-status
""")


def thermal(folder):
    """Growth from a sensor on a pin, once it has started; one that jumps or is missing keeps its share and is reported."""
    edited_tables(folder, os.path.join(SAMPLES, "mill-3axis"), "mill", geometry_alone, None)
    with open(os.path.join(folder, "thermal.toml"), "w") as f:
        f.write(THERMAL_TOML)
    compile_thermal(folder, "thermal.toml", os.path.join(SAMPLES, "mill-3axis"), "mill.ttherm")
    code, printed = rig.halrun(folder, THERMAL_HAL)
    values = [float(line) for line in printed.splitlines() if line.strip()[:1] in list("-0123456789")]
    expect(code == 0 and len(values) == 6, "halrun", printed)
    cold, warm, jumped, status_jumped, missing, status_missing = values
    with open(os.path.join(SAMPLES, "mill-3axis", "x.csv")) as f:
        forward, reverse = next(line.split(",")[1:3] for line in f if line.startswith("100,"))
    play = 1e-3 * (float(reverse) - float(forward))
    # 2 um and 4 um/m at 100 mm.
    expect(abs(warm - cold + 0.0024 + play) < 1e-6, "correction changed by %g mm" % (warm - cold))
    expect(jumped == warm and status_jumped == 3, "after a jump", values)
    expect(missing == warm and status_missing == 1, "without a sensor", values)
    return "correction %.5f mm cold, %.5f mm warm" % (cold, warm)


ACCEPTED_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt trueaxis names=ta tables=mill.tcomp units=mm
setp ta.enable 1
addf ta.update-feedback servo-thread
addf ta.update-output servo-thread
start
getp ta.x.slope
setp ta.x.max-slope 5
loadusr -w mv wide.tcomp mill.tcomp
setp ta.reload 1
loadusr -w sleep 0.3
getp ta.reload-code
getp ta.x.slope
getp ta.tables-ok
setp ta.x.max-slope 4.5
loadusr -w sleep 0.1
getp ta.tables-ok
setp ta.reload 0
setp ta.x.max-slope 7.5
loadusr -w sleep 0.1
setp ta.reload 1
loadusr -w sleep 0.3
getp ta.reload-code
getp ta.x.slope
"""


def accepted(folder):
    """Tables with larger limits than the integrator accepts never come into force."""
    machine = os.path.join(SAMPLES, "mill-3axis")
    compile_tables(folder, os.path.join(machine, "machine.toml"), "mill.tcomp")
    edited_tables(folder, machine, "wide", lambda text: text.replace(
        "[axis.X.thermal]", "[axis.X.limits]\nslope_mm_per_s = 7.5\n\n[axis.X.thermal]"), None)
    code, printed = rig.halrun(folder, ACCEPTED_HAL)
    values = [line.strip() for line in printed.splitlines() if "Note:" not in line and "trueaxis" not in line]
    expect(code == 0 and [v for v in values if v] == ["5", "1004", "5", "TRUE", "FALSE", "0", "7.5"], "pins", printed)
    return "refused with 1004"


PERIOD_HAL = """
loadrt threads name1=servo-thread period1=2000000
loadrt trueaxis names=ta tables=stream.tcomp units=mm
setp ta.enable 1
setp ta.joint.0.motor-pos-cmd-in 12.5
addf ta.update-feedback servo-thread
addf ta.update-output servo-thread
start
loadusr -w sleep 0.2
getp ta.joint.0.motor-pos-cmd-out
getp ta.fault-code
getp ta.stop-request
getp ta.tables-ok
"""


def period(folder):
    """If the thread's period differs from that of the tables, the command passes and a stop is requested."""
    compile_tables(folder, os.path.join(rig.MACHINES, "stream", "machine.toml"), "stream.tcomp")
    code, printed = rig.halrun(folder, PERIOD_HAL)
    lines = [line.strip() for line in printed.splitlines() if "Note:" not in line and line.strip()]
    values = [line for line in lines if not line.startswith("trueaxis: ")]
    expect(code == 0 and values == ["12.5", "32", "TRUE", "FALSE"], "pins", printed)
    said = [line for line in lines if "found a thread of 2000000 ns, needed servo_period_nsec=1000000" in line]
    expect(len(said) == 1, "one line that says why", printed)
    return "fault 32"


NOWHERE_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt trueaxis names=ta tables=mill.tcomp units=mm
setp ta.enable 1
setp ta.joint.0.homed 1
setp ta.joint.1.homed 1
setp ta.joint.2.homed 1
setp ta.joint.0.pos-cmd nan
setp ta.joint.0.motor-pos-cmd-in nan
setp ta.joint.1.pos-cmd 8
setp ta.joint.1.motor-pos-cmd-in 8
setp ta.joint.2.pos-cmd -9
setp ta.joint.2.motor-pos-cmd-in -9
setp ta.joint.0.motor-pos-fb-in 7
setp ta.joint.1.motor-pos-fb-in nan
setp ta.joint.2.motor-pos-fb-in -9
addf ta.update-feedback servo-thread
addf ta.update-output servo-thread
start
""" + "".join("""%sloadusr -w sleep 0.1
getp ta.joint.0.motor-pos-cmd-out
getp ta.joint.1.motor-pos-cmd-out
getp ta.joint.2.motor-pos-cmd-out
getp ta.no-output
getp ta.stop-request
getp ta.fault-code
""" % change for change in (
    "",
    "setp ta.joint.1.motor-pos-fb-in 8.25\nsetp ta.joint.1.alarm 1\n",
    "setp ta.joint.1.alarm 0\n",
    "setp ta.joint.1.motor-pos-fb-in 60\n",
    "setp ta.joint.0.pos-cmd 7\nsetp ta.joint.0.motor-pos-cmd-in 7\nsetp ta.joint.1.pos-cmd 8.25\n"
    "setp ta.joint.1.motor-pos-cmd-in 8.25\nsetp ta.joint.1.motor-pos-fb-in 8.25\nsetp ta.enable 0\nsetp ta.reset 1\n",
))


def no_output(folder):
    """Without a usable command, and with an encoder that is not read, no output is invented; once all axes are read, it holds."""
    compile_tables(folder, os.path.join(SAMPLES, "mill-3axis", "machine.toml"), "mill.tcomp")
    code, printed = rig.halrun(folder, NOWHERE_HAL)
    found = [line.strip() for line in printed.splitlines() if re.match(r"\s*(-?\d|TRUE|FALSE|nan)", line)]
    wanted = [
        ["7", "0", "-9", "TRUE", "TRUE", "16"],
        ["7", "0", "-9", "TRUE", "TRUE", "16"],
        ["7", "8.25", "-9", "FALSE", "TRUE", "16"],
        ["7", "8.25", "-9", "FALSE", "TRUE", "16"],
        ["7", "8.25", "-9", "FALSE", "FALSE", "0"],
    ]
    expect(code == 0 and found == sum(wanted, []), "pins", found, printed)
    return "no output until the last encoder was read"


def damaged(source, target, change):
    with open(source, "rb") as f:
        data = bytearray(f.read())
    change(data)
    with open(target, "wb") as f:
        f.write(data)


def refused(folder):
    """loadrt refuses bad files and parameters with one line and a negative errno, and leaves nothing in HAL."""
    compile_tables(folder, os.path.join(SAMPLES, "mill-3axis", "machine.toml"), "good.tcomp")
    compile_tables(folder, os.path.join(SAMPLES, "mill-5axis", "machine.toml"), "five.tcomp")
    good = os.path.join(folder, "good.tcomp")
    damaged(good, os.path.join(folder, "damaged.tcomp"), lambda data: data.__setitem__(300, data[300] ^ 1))
    damaged(good, os.path.join(folder, "short.tcomp"), lambda data: data.__delitem__(slice(-5, None)))
    open(os.path.join(folder, "empty.tcomp"), "w").close()
    os.mkfifo(os.path.join(folder, "pipe.tcomp"))
    with open(os.path.join(folder, "huge.tcomp"), "wb") as f:
        f.truncate(2 << 20)
    many(folder)
    cases = [
        ("", "no table file", 22),
        ("tables=absent.tcomp", "absent.tcomp: cannot be opened: No such file", 2),
        ("tables=damaged.tcomp", "damaged.tcomp: ", 22),
        ("tables=short.tcomp", "short.tcomp: ", 22),
        ("tables=empty.tcomp", "empty.tcomp: ", 22),
        ("tables=.", ".: cannot be read: found no ordinary file", 22),
        ("tables=pipe.tcomp", "pipe.tcomp: cannot be read: found no ordinary file", 22),
        ("tables=good.tcomp names=abcdefghijklmnopqrstuv", "needed: below 22 bytes", 22),
        ("tables=huge.tcomp", "huge.tcomp: too long", 7),
        ("tables=many.tcomp", "many.tcomp: too many points", 7),
        ("tables=good.tcomp joints=XYZA", "found no axis A", 22),
        ("tables=good.tcomp joints=XY", "found axis Z", 22),
        ("tables=five.tcomp joints=XYZ", "found axis A", 22),
        ("tables=good.tcomp joints=XYW", "joints=XYW", 22),
        ("tables=good.tcomp joints=XYYZ joint_tables=1=good.tcomp", "needed one of Y alone", 22),
        ("tables=good.tcomp joint_tables=7=good.tcomp joints=XYZ", "joint 7", 22),
        ("tables=good.tcomp,good.tcomp count=9", "count=9", 22),
        ("tables=good.tcomp count=2", "trueaxis.1: no table file", 22),
        ("tables=good.tcomp names=a count=2", "names= and count=", 22),
        ("tables=good.tcomp servo_period_nsec=10", "servo_period_nsec=10", 22),
    ]
    cases = [("units=mm " + parameters, line, errno) for parameters, line, errno in cases] + [
        ("tables=good.tcomp", "found no unit of length; needed: units=[TRAJ]LINEAR_UNITS", 22),
        ("tables=good.tcomp units=", "found no unit of length; needed: units=[TRAJ]LINEAR_UNITS", 22),
        ("tables=good.tcomp,good.tcomp count=2 inch=1", "trueaxis.1: found no unit of length", 22),
        ("tables=good.tcomp units=cm", "units=cm; needed: mm or inch", 22),
        ("tables=good.tcomp units=25.4", "units=25.4; needed: mm or inch", 22),
        ("tables=good.tcomp units=mm inch=1", "found units=mm and inch=1; needed: one unit", 22),
        ("tables=good.tcomp units=imperial inch=0", "found units=imperial and inch=0; needed: one unit", 22),
        ("tables=good.tcomp inch=2", "inch=2; needed: 1 (inches) or 0 (mm)", 22),
        ("tables=good.tcomp units=mm angular_units=radian", "angular_units=radian; needed: degree", 22),
        ("tables=five.tcomp units=mm", "found no unit of angle for axis A, needed angular_units=[TRAJ]ANGULAR_UNITS", 22),
    ]
    for parameters, line, errno in cases:
        code, printed = rig.halrun(folder, "loadrt trueaxis %s\nshow comp\n" % parameters)
        own = [text for text in printed.splitlines() if text.startswith("trueaxis: ") and "rtapi_app_main" not in text]
        expect(len(own) == 1 and line in own[0], "loadrt trueaxis %s: no one line with %r" % (parameters, line), printed)
        expect("(-%d)" % errno in printed, "loadrt trueaxis %s: not errno %d" % (parameters, errno), printed)
        expect(code != 0, "loadrt trueaxis %s succeeded" % parameters, printed)
    return "%d refusals" % len(cases)


def many(folder):
    """loadrt refuses a table with more points than the component has memory for."""
    source = os.path.join(folder, "many")
    os.makedirs(source)
    columns = ",".join("E%sX_%s" % (c, "urad" if c in "ABC" else "um") for c in "XYZABC")
    with open(os.path.join(source, "x.csv"), "w") as f:
        f.write("X_mm,%s\n" % columns)
        for n in range(14000):
            f.write("%g,%s\n" % (0.01 * n, ",".join("%g" % (0.001 * ((n * k) % 7)) for k in range(1, 7))))
    with open(os.path.join(source, "machine.toml"), "w") as f:
        f.write('name = "many"\nchain = "w b X Y Z t"\n[axis.X]\ntable = "x.csv"\n')
    compile_tables(folder, os.path.join(source, "machine.toml"), "many.tcomp")


TESTS = (refused, stream, gauge, instances, joint_stop, warm, thermal, accepted, period, no_output)
