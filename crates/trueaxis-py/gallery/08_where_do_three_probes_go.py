"""Where do three probes go? The angles at which no harmonic is lost, and what the best ones do to the noise."""

import trueaxis

found = trueaxis.probe_angles(n=1024, count=3)
for pair in found.best:
    print(f"probes at 0°, {pair.phi2_deg:.2f}° and {pair.phi2_deg + pair.phi3_deg:.2f}°")
