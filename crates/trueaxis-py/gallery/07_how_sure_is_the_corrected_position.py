"""How sure is the corrected position? The uncertainty that the calibration leaves, and where it comes from."""

import trueaxis

mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
found = mill.uncertainty(points=5, trials=2000)
print(found)
print(found.to_frame(found.tables[-1]).head())
