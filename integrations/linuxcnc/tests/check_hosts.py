"""Replays the recording common to all hosts: drive positions compared with the library's."""
import csv
import json
import os

import rig
from recording import Recording
from rig import expect

RECORDING = os.environ["TRUEAXIS_HOSTS"]
# A queue holds one row less than its depth, and the streamer waits for ever if the thread does not run yet.
REPLAY_HAL = """
loadrt threads name1=servo-thread period1=1000000
loadrt streamer depth=%(depth)d cfg=ffffff
loadrt trueaxis names=ta tables=machine.tcomp joints=XYZ units=mm
loadrt sampler depth=%(depth)d cfg=fff
setp ta.enable 1
%(nets)saddf streamer.0 servo-thread
addf ta.update-feedback servo-thread
addf ta.update-output servo-thread
addf sampler.0 servo-thread
loadusr -w halstreamer stream.in
start
loadusr -w /usr/bin/python3 %(collect)s %(cycles)d run
"""
NETS = """setp ta.joint.{0}.homed 1
net {1}-command streamer.0.pin.{0} => ta.joint.{0}.pos-cmd ta.joint.{0}.motor-pos-cmd-in
net {1}-encoder streamer.0.pin.{2} => ta.joint.{0}.motor-pos-fb-in
net {1}-drive ta.joint.{0}.motor-pos-cmd-out => sampler.0.pin.{0}
"""


def one_proof(folder):
    """The recording common to all hosts, command by command and reading by reading: the drives get the library's bits."""
    rig.copy(folder, RECORDING, "machine.tcomp")
    with open(os.path.join(RECORDING, "run.csv")) as f:
        rows = list(csv.DictReader(f))
    expect(all(row["homed"] == row["enable"] == "1" and row["fault"] == "0" for row in rows), "needed a run without events")
    with open(os.path.join(folder, "stream.in"), "w") as f:
        for row in rows:
            f.write(" ".join([row[a + "_cmd_mm"] for a in "xyz"] + [row[a + "_mm"] for a in "xyz"]) + "\n")
    nets = "".join(NETS.format(j, axis, j + 3) for j, axis in enumerate("xyz"))
    collect = os.path.join(rig.HERE, "collect.py")
    code, printed = rig.halrun(folder, REPLAY_HAL % {"cycles": len(rows), "depth": len(rows) + 2, "nets": nets, "collect": collect}, 60)
    expect(code == 0, "halrun", printed)
    sent = Recording.load(os.path.join(folder, "run")).rows
    expect(len(sent) == len(rows), "%d samples of %d" % (len(sent), len(rows)))
    pairs = [(float(row[a + "_drive_mm"]), drive[j]) for row, drive in zip(rows, sent) for j, a in enumerate("xyz")]
    result = {"host": "linuxcnc", "samples": len(pairs), "same": sum(a == b for a, b in pairs),
              "largest_mm": max(abs(a - b) for a, b in pairs)}
    with open(os.path.join(folder, "linuxcnc.json"), "w") as f:
        json.dump(result, f)
    expect(result["same"] == result["samples"], "drive positions differ", result)
    return "%(samples)d drive positions, %(same)d the same to the last bit" % result


TESTS = (one_proof,)
