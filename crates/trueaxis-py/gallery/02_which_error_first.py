"""Which error first? The causes of a circular test, the largest first."""

import matplotlib.pyplot as plt
import numpy as np

import trueaxis

# A record of a ballbar: two turns in each direction, with 40 µrad of squareness and 3 µm of lost motion.
rows, noise = [], np.random.default_rng(5)
for direction in (1, -1):
    degrees = np.arange(0.5, 720, 1)
    angle = np.radians(degrees)
    um = -0.5 * 100e3 * 40e-6 * np.sin(2 * angle) + 1.5 * direction * np.sign(np.sin(angle)) * np.cos(angle)
    rows.append(np.column_stack([degrees, um + noise.normal(0, 0.05, len(angle)), np.full(len(angle), direction)]))

found = trueaxis.ballbar(np.vstack(rows), radius_mm=100)
print(found)
for share in found.shares[:3]:
    print(f"{share.cause}: {share.rms_um:.2f} µm, {share.share:.0%}")
found.plot()
plt.show()
