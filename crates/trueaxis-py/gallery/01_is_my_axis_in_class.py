"""Is my axis in class? ISO 230-2 of a measured axis, and a verdict with the uncertainty of the instrument."""

import trueaxis

mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
found = trueaxis.accuracy("compensation-tables/mill-3axis/x-iso230-2.csv", machine=mill, instrument=mill, tolerance_um=40)

print(found)
accuracy = found.figures["A, bidirectional accuracy"]
print(f"A is {accuracy}, at most {found.verdict.tolerance_um:g} µm: {found.verdict.verdict}")
