"""Holds what the C example printed on host, Cortex-M4F and Cortex-M7 against each other (see test.sh)."""

import re
import sys
from pathlib import Path

# Correction and contour error of single precision against double precision, um.
TOLERANCE_UM = 0.002

out = Path(sys.argv[1])
failures = []


def lines(name):
    return (out / f"{name}.txt").read_text().splitlines()


def figures(name):
    found = {}
    for line in lines(name):
        if match := re.fullmatch(r"(correction [XYZ]|largest dynamic [XYZ]|worst contour error) (\S+) um", line):
            found[match[1]] = float(match[2])
    return found


def expect(holds, what):
    if not holds:
        failures.append(what)


host = lines("host")
print(*host, sep="\n")
expect(host[0].startswith("machine mill-3axis, axes XYZ, "), "host: another machine than mill-3axis")
expect("cycles 8000, faults 5, last fault 0" in host[1], "host: 8000 cycles with 5 faults are expected")
expect(host == lines("m7"), "Cortex-M7: not bit for bit what the host printed")

double, single = figures("host"), figures("m4f")
expect(len(double) == 7 and double.keys() == single.keys(), "figures are missing")
for name, value in double.items():
    difference = abs(single[name] - value)
    print(f"Cortex-M4F, {name}: {1e3 * difference:.3f} nm from double precision")
    expect(difference <= TOLERANCE_UM, f"Cortex-M4F: {name} is {single[name]} um, needed {value} um +- 2 nm")
    # Z stands still.
    expect(abs(value) > 0.1 or name == "largest dynamic Z", f"{name} of {value} um shows nothing")

refusals = {
    "damaged": ("result 6, code 5: table file: the file is damaged", 33),
    "memory": ("result 9, code 0: memory: found 8192 bytes", 34),
    "abi": ("result 5, header ", 35),
}
for path in sorted(out.glob("*-*.txt")):
    name = path.stem
    text, fault = refusals[name.split("-")[1]]
    got = lines(name)
    expect(got[0].startswith("refused: " + text), f"{name}: {got[0]}")
    expect(f"cycles 8000, faults 8000, last fault {fault}, tables 00000000" in got, f"{name}: {got[1]}")
    print(f"{name}: {got[0]}; {got[1]}")

for failure in failures:
    print("FAILED", failure, file=sys.stderr)
sys.exit(1 if failures else 0)
