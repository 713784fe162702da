// Initial task: a ball on the sample mill.

export const SAMPLE = `machine = "mill-3axis"              # here: the machine that is shown, or one dropped with the task
dialect = "linuxcnc"                # or grblhal, klipper
every_parts = 10                    # parts between two re-probings

[probe]
tip_radius_mm = 3.0
tip_uncertainty_um = 5.0
repeatability_um = 1.0

[[artefact]]
name = "ball"                       # stays where it is
kind = "ball"
diameter_mm = 25.0
uncertainty_um = 0.3
[[artefact.place]]
at_mm = [-200.0, -120.0, -250.0]    # X, Y, Z of the machine with the tip in its middle

[[term]]
names = ["offset X", "offset Y", "offset Z"]
largest_update_um = 15.0            # more than that at once needs a person
largest_total_um = 40.0             # and so does more than that since the beginning
significance = 3.0                  # a term has moved by more than so many of its standard errors
`;
