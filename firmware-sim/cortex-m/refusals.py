"""Inputs that an image has to refuse, and the expected message of each.

    refusals.py machines MACHINE FOLDER    variants of the machine file that this image has no room for
    refusals.py make FOLDER                the inputs, from FOLDER's good, mill, wide and points.tcomp, good and mill.ttherm,
                                           and small.rec
    refusals.py check NAME FOLDER CORE     what an image sent and logged in FOLDER/CORE, run with the inputs NAME
"""

import re
import struct
import sys
import zlib
from pathlib import Path

PERIOD_NS = 1_000_000
LENGTH_AT, HEADER, SUM = 14, 18, 4

# name: exit code, fault in every record, text expected in the log.
CASES = {
    "damaged": (0, 33, "tables A refused: fault 33 TablesRefused, code 5, File(Checksum)"),
    "foreign": (0, 33, "tables A refused: fault 33 TablesRefused, code 3, File(Magic)"),
    "truncated": (0, 33, "tables A refused: fault 33 TablesRefused, code 5, File(Checksum)"),
    "endless": (0, 33, "tables A refused: fault 33 TablesRefused, code 1, File(TooShort)"),
    "empty": (0, 33, "tables A refused: fault 33 TablesRefused, code 3, File(Magic)"),
    "machine": (0, 33, "tables A refused: fault 33 TablesRefused, code 12, File(WrongMachine)"),
    "wide": (0, 34, "tables A refused: fault 34 CapacityTooSmall, code 0, Capacity"),
    "points": (0, 34, "tables A refused: fault 34 CapacityTooSmall, code 0, Points"),
    "period": (0, 32, "tables A refused: fault 32 PeriodMismatch, code 0, Period"),
    "exchange": (0, 0, "tables B refused: fault 33 TablesRefused, code 5, File(Checksum)"),
    "growth": (0, 0, "growth refused: damaged: the sum is wrong; none is compensated"),
    "growth-foreign": (0, 0, "growth refused: no readings; none is compensated"),
    "growth-endless": (0, 0, "growth refused: shorter than it says; none is compensated"),
    "growth-machine": (0, 0, "growth refused: found on the machine "),
    "growth-sensors": (0, 0, "growth refused: not as many sensors as the growth has; none is compensated"),
    "growth-interval": (0, 0, "growth refused: less than two cycles between two readings; none is compensated"),
    "recording": (1, None, "recording refused: damaged"),
    "no-recording": (1, None, "recording refused: no recording"),
}


def machines(machine, folder):
    text = machine.read_text()
    for name in ("wide", "points"):
        to = folder / name
        to.mkdir(parents=True, exist_ok=True)
        tables = re.compile('table = "(.*)"')
        own = tables.sub(lambda table: f'table = "{(machine.parent / table[1]).resolve()}"', text)
        if name == "points":
            # Slots of another division, and fewer harmonics than points can tell apart.
            own = re.sub("points = .*", "points = 512", own)
            own = re.sub("probe_slots = .*", "probe_slots = [94, 333]", own)
        else:
            for axis, low, high in (("x", -300, 300), ("y", -200, 200), ("z", -400, 0)):
                lines = (f"{low + (high - low) * i / 2000},0.1" for i in range(2001))
                letter = axis.upper()
                head = f"{letter}_mm,E{letter}{letter}_um"
                (to / f"{axis}.csv").write_text("\n".join([head, *lines]) + "\n")
            own = tables.sub(lambda table: f'table = "{Path(table[1]).name}"', text)
        (to / "machine.toml").write_text(own)


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def flipped(data, at):
    return data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :]


def summed(data):
    return data + struct.pack("<I", zlib.crc32(data))


def warming(growth, sensors=2, interval=100, rows=5):
    """Thermal growth as flashed: settings of the task, and readings of 20 °C that rise by 1 K a row."""
    head = b"TAXISTMP" + struct.pack("<HII", 1, interval, len(growth)) + growth + struct.pack("<BI", sensors, rows)
    readings = (value for row in range(rows) for value in [20_000 + 1_000 * row] * sensors + [0])
    return summed(head + b"".join(struct.pack("<i", value) for value in readings))


def growths(growth, other):
    good = warming(growth)
    # The file's length follows magic, version and interval.
    endless = good[:LENGTH_AT] + struct.pack("<I", 0x7FFFFFFF) + good[HEADER:]
    return {
        "exchange": good,
        "growth": flipped(good, len(good) - 20),
        "growth-foreign": growth,
        "growth-endless": endless,
        "growth-machine": warming(other),
        "growth-sensors": warming(growth, sensors=3),
        "growth-interval": warming(growth, interval=1),
    }


def make(folder):
    good, recording = (folder / "good.tcomp").read_bytes(), (folder / "small.rec").read_bytes()
    damaged = flipped(good, len(good) // 2)
    endless = good[:LENGTH_AT] + struct.pack("<I", 0x7FFFFFFF) + good[HEADER:]
    assert recording.count(varint(PERIOD_NS)) >= 1, "the recording's period"
    period = recording[:-SUM].replace(varint(PERIOD_NS), varint(PERIOD_NS + 2000), 1)
    tables = {
        "damaged": damaged,
        "foreign": b"X_mm,EXX_um\n0,0\n100,3\n",
        "truncated": good[: len(good) // 2],
        "endless": endless,
        "empty": None,
        "machine": (folder / "mill.tcomp").read_bytes(),
        "wide": (folder / "wide.tcomp").read_bytes(),
        "points": (folder / "points.tcomp").read_bytes(),
    }
    recordings = {"period": summed(period), "recording": flipped(recording, len(recording) // 2), "no-recording": None}
    warm = growths(*((folder / f"{name}.ttherm").read_bytes() for name in ("good", "mill")))
    for name in CASES:
        to = folder / name
        to.mkdir(exist_ok=True)
        for file, content in {
            "a.tcomp": tables.get(name, good),
            "b.tcomp": damaged if name == "exchange" else good,
            "warming.bin": warm.get(name),
            "run.rec": recordings.get(name, recording),
        }.items():
            (to / file).unlink(missing_ok=True)
            if content is not None:
                (to / file).write_bytes(content)
    print(*CASES)


def uncobs(frame):
    out = bytearray()
    at = 0
    while at < len(frame):
        count = frame[at]
        out += frame[at + 1 : at + count]
        at += count
        if count < 255 and at < len(frame):
            out.append(0)
    return bytes(out)


def unsigned(data, at):
    value, shift = 0, 0
    while True:
        value |= (data[at] & 127) << shift
        at, shift = at + 1, shift + 7
        if data[at - 1] < 128:
            return value, at


def records(data):
    """Sequence number, tables, fault and status of every record, and whether all its corrections are zero."""
    for frame in filter(None, data.split(b"\0")):
        record = uncobs(frame)
        assert record[0] == 3, f"found a record of version {record[0]}, needed 3"
        sequence, at = unsigned(record, 1)
        _, at = unsigned(record, at)
        crc, at = unsigned(record, at)
        fault, status, axes = record[at], record[at + 2], record[at + 5]
        corrections = [record[at + 6 + 21 * axis + 16 :][:4] for axis in range(axes)]
        yield sequence, crc, fault, status, not any(map(any, corrections))


def check(name, inputs, core):
    code, fault, words = CASES[name]
    folder = inputs / core
    found = int((folder / "exit").read_text())
    assert found == code, f"found exit code {found}, needed {code}"
    log = (folder / "log.txt").read_text()
    assert words in log, f"needed {words!r} in the log, found:\n{log}"
    if name == "exchange":
        grown = "growth: 5 times in force, 0 late, 0 readings left out"
        assert grown in log, f"needed {grown!r} in the log, found:\n{log}"
    sent = list(records((folder / "frames.bin").read_bytes()))
    if code:
        assert not sent, "found records of a run without a recording"
        return 0
    said = f"end: {len(sent)} cycles, 0 overruns, 0 records dropped"
    assert said in log, f"needed {said!r} in the log, found:\n{log}"
    assert [record[0] for record in sent] == list(range(len(sent))), "records are missing"
    good = None if fault else struct.unpack("<I", (inputs / "a.tcomp").read_bytes()[-SUM:])[0]
    for sequence, crc, code, status, still in sent:
        if fault:
            assert (code, crc, status, still) == (fault, 0, 0, True), f"cycle {sequence}: {code}, {crc:x}, {status}"
        else:
            assert code < 32 and crc == good, f"cycle {sequence}: fault {code}, tables {crc:08x}"
    if not fault:
        assert not all(still for *_, still in sent), "nothing was corrected"
    return len(sent)


if __name__ == "__main__":
    what, *arguments = sys.argv[1:]
    if what == "machines":
        machines(*map(Path, arguments))
    elif what == "make":
        make(Path(arguments[0]))
    else:
        name, folder, core = arguments
        try:
            count = check(name, Path(folder), core)
        except AssertionError as error:
            sys.exit(f"{name} on {core}: {error}")
        print(f"{name} on {core}: refused as it must be, {count} records say so")
