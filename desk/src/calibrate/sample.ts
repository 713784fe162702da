// Initial task: a ring and a ball on the sample mill.

export const SAMPLE = `machine = "mill-3axis"              # here: the machine that is shown, or one dropped with the task
dialect = "linuxcnc"                # or grblhal, klipper

[probe]
tip_radius_mm = 3.0
repeatability_um = 1.0

[reference]
artefact = "ball"                   # touched again and again against drift
every = 60

[[artefact]]
name = "ball"
kind = "ball"
diameter_mm = 25.0
uncertainty_um = 0.2
[[artefact.place]]
at_mm = [-200.0, -120.0, -250.0]    # X, Y, Z of the machine with the tip in its middle

[[artefact]]
name = "ring"
kind = "ring"
diameter_mm = 150.0
uncertainty_um = 0.2
[[artefact.place]]
at_mm = [0.0, 0.0, -200.0]
[[artefact.place]]
at_mm = [0.0, 0.0, -200.0]
normal = "Y"
[[artefact.place]]
at_mm = [0.0, 0.0, -200.0]
normal = "X"
`;
