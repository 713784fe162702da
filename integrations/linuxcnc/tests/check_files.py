"""Files, parameters and streams: without a machine around the component."""
import os

import rig
from machines import SAMPLES, compile_tables
from rig import expect

STREAM_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt streamer depth=4000 cfg=fff
loadrt trueaxis names=ta tables=stream.tcomp joints=XYZ
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
    """streamer -> component -> sampler, against what the straight lines of the tables give in closed form."""
    compile_tables(folder, os.path.join(rig.MACHINES, "stream", "machine.toml"), "stream.tcomp")
    home = 37.0
    way = [0.125 * n for n in range(801)] + [100.0] * 20 + [100.0 - 0.125 * n for n in range(1, 1601)]
    with open(os.path.join(folder, "stream.in"), "w") as f:
        for x in way:
            f.write("%r %r %r\n" % (x, x + home, 0.0))
    code, printed = rig.halrun(folder, STREAM_HAL % len(way))
    expect(code == 0, "halrun", printed)
    expected, before = [], None
    for x in way:
        # Where the tool is told to be x: y + 1e-4 y = x, and Z is off by 5e-5 y. The first cycle passes the command.
        y = x / 1.0001 if before is not None else x
        z = -5e-5 * y if before is not None else 0.0
        back = before + home if before is not None else 0.0
        expected.append((y + home, back, z, y - x))
        before = x
    sampled = [line.split() for line in printed.splitlines() if line.count(" ") >= 3 and line[0] in "-0123456789"]
    expect(len(sampled) == len(way), "%d samples of %d" % (len(sampled), len(way)), printed[:2000])
    for n, (got, wanted) in enumerate(zip(sampled, expected)):
        # halsampler prints six decimals; the exact inverse stops at 1e-9 of what it inverts.
        expect(all(abs(float(g) - w) <= 0.5e-6 + 1e-9 for g, w in zip(got, wanted)), "sample %d" % n, got, wanted)
    return "%d samples exact to the sixth decimal" % len(sampled)


def damaged(source, target, change):
    with open(source, "rb") as f:
        data = bytearray(f.read())
    change(data)
    with open(target, "wb") as f:
        f.write(data)


def refused(folder):
    """Files and parameters that loadrt must refuse: one line, a negative errno, nothing left in HAL."""
    compile_tables(folder, os.path.join(SAMPLES, "mill-3axis", "machine.toml"), "good.tcomp")
    compile_tables(folder, os.path.join(SAMPLES, "mill-5axis", "machine.toml"), "five.tcomp")
    good = os.path.join(folder, "good.tcomp")
    damaged(good, os.path.join(folder, "damaged.tcomp"), lambda data: data.__setitem__(300, data[300] ^ 1))
    damaged(good, os.path.join(folder, "short.tcomp"), lambda data: data.__delitem__(slice(-5, None)))
    open(os.path.join(folder, "empty.tcomp"), "w").close()
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
    for parameters, line, errno in cases:
        code, printed = rig.halrun(folder, "loadrt trueaxis %s\nshow comp\n" % parameters)
        own = [text for text in printed.splitlines() if text.startswith("trueaxis: ") and "rtapi_app_main" not in text]
        expect(len(own) == 1 and line in own[0], "loadrt trueaxis %s: no one line with %r" % (parameters, line), printed)
        expect("(-%d)" % errno in printed, "loadrt trueaxis %s: not errno %d" % (parameters, errno), printed)
        expect(code != 0, "loadrt trueaxis %s succeeded" % parameters, printed)
    return "%d refusals" % len(cases)


def many(folder):
    """A table with more points than the component has memory for."""
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


TESTS = (refused, stream)
