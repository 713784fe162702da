"""Did the axes hit the contour? The distance of measured positions from the programmed path."""

import json

import matplotlib.pyplot as plt
import numpy as np

import trueaxis

path = trueaxis.Path.from_json(json.dumps({"segments": [
    {"type": "line", "start": [0, 0, 0], "end": [10, 0, 0]},
]}))
u = np.linspace(0.1, 0.9, 9)
actual = np.column_stack([10 * u, 0.002 * np.sin(7 * u), np.zeros(9)])
found = path.contour_error(np.zeros(9), u, actual)
print(f"largest contour error: {found['error_um'].max():.2f} µm")

plt.plot(10 * u, found["error_um"], "o-")
plt.xlabel("X in mm")
plt.ylabel("distance from the path in µm")
plt.show()
