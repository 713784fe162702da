"""What do the tables leave of my part? A simulated run with drives, encoders and the machine's exact geometry."""

import trueaxis

mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
part = trueaxis.Program.from_text("G21 G90 G17 F1500\nG1 X12\nG2 X12 Y-24 J-12\nG1 X0 Y0\nM2\n", name="half circle")
made = trueaxis.simulate(mill, part, rate_hz=1000, seed=3)
for machine in ("uncompensated", "compensated"):
    error = made["contour_error_um"][machine]
    print(f"{machine}: {error['max']:.2f} µm at most, {error['rms']:.2f} µm RMS")
