"""How round is it, and how good is the spindle? Three probes separate the part from the spindle."""

import matplotlib.pyplot as plt
import numpy as np

import trueaxis

n = 1024
best = trueaxis.probe_angles(n=n).best[0]

# A part with three lobes on a spindle with an error motion at twice the speed, both in µm.
theta = 2 * np.pi * np.arange(4 * n) / n
readings = np.column_stack([
    1.5 * np.cos(3 * (theta + angle)) + 0.4 * np.cos(2 * theta) * np.cos(angle) + 0.3 * np.sin(2 * theta) * np.sin(angle)
    for angle in 2 * np.pi / n * np.array([0, best.p, best.p + best.q])
])
found = trueaxis.roundness(readings, n=n, p=best.p, q=best.q)
print(found)
found.plot(which=found.plots[0])
plt.show()
