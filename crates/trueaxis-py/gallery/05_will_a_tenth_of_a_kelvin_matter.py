"""Will 0.1 K matter? The growth of the machine over its travel."""

import matplotlib.pyplot as plt
import numpy as np

import trueaxis

mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
along_x = np.column_stack([np.linspace(-150, 150, 61), np.zeros(61), np.full(61, -200.0)])
warm = mill.error(along_x, temperature_c=20.1) - mill.error(along_x, temperature_c=20.0)
print(f"0.1 K moves the tip by up to {np.abs(warm[:, 0]).max():.2f} µm over 300 mm of X")

plt.plot(along_x[:, 0], warm, label=["X", "Y", "Z"])
plt.xlabel("X in mm")
plt.ylabel("growth by 0.1 K in µm")
plt.legend()
plt.show()
