"""Which machine of the fleet needs a screw? What tables of axes would leave, machine by machine."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import trueaxis

fleet = ["mill-3axis", "mill-5axis", "head-5axis"]
rows = []
for name in fleet:
    machine = trueaxis.Machine.load(f"compensation-tables/{name}")
    spread = np.random.default_rng(1).uniform(-60, 60, (2000, 3)) + ([0, 0, -200] if name == "mill-3axis" else [0, 0, 0])
    there, back = machine.error(spread), machine.error(spread, reverse=True)
    rows.append({
        "machine": name,
        "largest_um": np.linalg.norm(there, axis=1).max(),
        "lost_motion_um": np.abs(there - back).max(),
    })
table = pd.DataFrame(rows).set_index("machine").sort_values("lost_motion_um", ascending=False)
print(table.round(2))
table.plot.barh(xlabel="µm")
plt.show()
