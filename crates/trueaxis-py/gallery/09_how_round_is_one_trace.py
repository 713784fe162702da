"""How round is one trace? The four reference circles of ISO 12181-1, after a filter of 50 undulations per revolution."""

import matplotlib.pyplot as plt
import numpy as np

import trueaxis

theta = np.arange(0, 360, 0.25)
angle = np.radians(theta)
noise = np.random.default_rng(2).normal(0, 0.0002, len(theta))
radius = 25 + 0.05 * np.cos(angle) + 0.002 * np.cos(3 * angle) + 0.0005 * np.cos(170 * angle) + noise

found = trueaxis.trace_roundness(radius, upr=50)
print(found)
rough = trueaxis.trace_roundness(radius)
print(f"roundness, minimum zone: {found.mzc.zone_um:.2f} µm; {rough.mzc.zone_um:.2f} µm without the filter")

# Departures from the least-squares circle: of a trace that is a little off centre, without the first harmonic.
x, y = found.lsc.centre_mm
departure = [1e3 * (circles.radius_mm - x * np.cos(angle) - y * np.sin(angle) - found.lsc.radius_mm) for circles in (rough, found)]
plt.plot(theta, departure[0], linewidth=0.5, label="trace")
plt.plot(theta, departure[1], label="filtered, 50 UPR")
plt.xlabel("angle in °")
plt.ylabel("departure in µm")
plt.legend()
plt.show()
