"""How round is one trace? The four reference circles of ISO 12181-1 for points on a section."""

import numpy as np

import trueaxis

angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
radius = 25 + 0.002 * np.cos(3 * angle) + 0.0005 * np.cos(17 * angle)
found = trueaxis.circle(np.column_stack([0.1 + radius * np.cos(angle), radius * np.sin(angle)]))
print(found)
print(f"roundness, minimum zone: {found.mzc.zone_um:.2f} µm")
