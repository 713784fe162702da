"""Compares the results of a probe and a mesh, and the resulting tool positions, with the bed: check(TRUEAXIS, MACHINE, RECORD).

SPDX-License-Identifier: GPL-3.0-or-later
"""
import json

from truth import HOME, height, tools

Z_OFFSET = 1.5
MESH = [20.0, 60.0, 100.0, 140.0, 180.0]
PLACES = (20, 20), (180, 30), (100, 100), (40, 170), (170, 180)
OTHER = 150, 40  # homed there too
ABOVE = 2.0
ALLOWED = 1.5  # microsteps; the touch is on a step, and so are the motors
SECTIONS = f"""
[probe]
pin: ^PA30
z_offset: {Z_OFFSET}
[bed_mesh]
mesh_min: {MESH[0]}, {MESH[0]}
mesh_max: {MESH[-1]}, {MESH[-1]}
probe_count: {len(MESH)}, {len(MESH)}
horizontal_move_z: 5
speed: 200
"""


def program():
    at = "G1 X%g Y%g F6000\n"
    text = "G28 X Y\nG90\n" + at % HOME + "G28 Z\n"
    for place in PLACES:
        text += "G1 Z8 F1200\n" + at % place + "PROBE\nBED_LOOK NAME=probed\n"
    text += "G1 Z8 F1200\n" + at % OTHER + "G28 Z\nG1 Z8 F1200\n" + at % PLACES[2] + "PROBE\nBED_LOOK NAME=homed\n"
    text += "G1 Z8 F1200\n" + at % HOME + "G28 Z\nG1 Z8 F1200\nBED_MESH_CALIBRATE\n"
    for place in PLACES:
        text += at % place + f"G1 Z{ABOVE} F1200\nBED_LOOK NAME=above\n"
    return text + "TRUEAXIS ENABLE=0\nTRUEAXIS ENABLE=1\nBED_LOOK NAME=switched\n"


def check(trueaxis, machine, record):
    """Returns the largest deviations, in microsteps, of points probed, mesh, tool above the bed, and positions reported."""
    looks = [entry for entry in map(json.loads, open(record)) if "look" in entry]
    stood = tools(trueaxis, machine, [entry["drives"] for entry in looks])
    largest = dict.fromkeys(("probed", "mesh", "above", "told"), 0.0)

    def held(what, found, needed):
        largest[what] = max(largest[what], abs(found - needed) / looks[0]["step"])

    places = iter(PLACES)
    for entry, tool in zip(looks, stood):
        # The host's Z is 0 where the nozzle touched the bed when Z was homed.
        zero, bed = height(*OTHER) if entry["look"] == "homed" else 0.0, height(*tool[:2])
        if entry["look"] in ("probed", "homed"):
            place = next(places) if entry["look"] == "probed" else PLACES[2]
            held("probed", entry["probed"], height(*place) + Z_OFFSET - zero)
            if entry["look"] == "homed":
                places = iter(PLACES)
        else:
            place = next(places) if entry["look"] == "above" else PLACES[-1]
            held("above", tool[2], bed + ABOVE)
            bed += zero
            for row, y in zip(entry["mesh"], MESH):
                for found, x in zip(row, MESH):
                    held("mesh", found, height(x, y))
        for axis in (0, 1):
            held("told", entry["told"][axis], tool[axis])
            if entry["look"] in ("above", "switched"):  # while a probe goes down, the correction is held
                held("above", tool[axis], place[axis])
        held("told", entry["told"][2], tool[2] - (zero if entry["look"] in ("probed", "homed") else bed))
    return largest
