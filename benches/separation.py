#!/usr/bin/env python3
"""Time of the offline separation beside numpy's for the same: profile and motion of every revolution of a record.

Usage: separation.py [REVOLUTIONS]        needs numpy; without it, says so and ends well

N = 1024, p = 188, q = 667, harmonics 2..100, arm of ratio 0.2. numpy: weighted sum, rfft, times 1/G, irfft of the profile,
its turned copy, R_X and R_Y, all revolutions in one array each; and revolution by revolution, which stays in the cache. Ours:
the example `separation` of trueaxis-metrology, release build, one thread. Each the best of twenty runs. Both results are
compared.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

# One thread for numpy too.
os.environ["OMP_NUM_THREADS"] = "1"
try:
    import numpy as np
except ImportError:
    print("skipped: numpy is not installed")
    sys.exit(0)

N, P, Q, FIRST, LAST, RATIO = 1024, 188, 667, 2, 100, 0.2
REVOLUTIONS = int(sys.argv[1]) if len(sys.argv) > 1 else 200

THETA = 2 * np.pi * np.arange(N) / N
PHI2, PHI3 = 2 * np.pi * P / N, 2 * np.pi * Q / N
K2, K3 = -np.sin(PHI2 + PHI3) / np.sin(PHI3), np.sin(PHI2) / np.sin(PHI3)
K = np.arange(N // 2 + 1)
GAIN = 1 + K2 * np.exp(1j * K * PHI2) + K3 * np.exp(1j * K * (PHI2 + PHI3))
INVERSE = np.where((K >= FIRST) & (K <= LAST), 1 / np.where(np.abs(GAIN) > 1e-9, GAIN, 1), 0)
DIRECTION = 1 + RATIO * np.exp(1j * THETA)
BETA = np.angle(DIRECTION)


def separate(h1, h2, h3):
    """Profile, R_X and R_Y by the equations as they are published (R_Y corrected)."""
    spectrum = np.fft.rfft(h1 + K2 * h2 + K3 * h3)
    profile = np.fft.irfft(spectrum * INVERSE, n=N)
    radius = (spectrum[..., :1].real / N) / GAIN[0].real
    one, two = h1 - profile - radius, h2 - np.roll(profile, -P, axis=-1) - radius
    x = (np.cos(BETA) * two - np.cos(PHI2 + BETA) * one) / np.sin(PHI2)
    y = (np.sin(PHI2 + BETA) * one - np.sin(BETA) * two) / np.sin(PHI2)
    return profile, x, y


def best(function):
    """Best of twenty runs, s."""
    times = []
    for _ in range(20):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def main():
    random = np.random.default_rng(1)
    readings = [random.normal(0.0, 5.0, (REVOLUTIONS, N)) for _ in range(3)]
    truth = separate(*readings)
    at_once = best(lambda: separate(*readings))
    one_by_one = best(lambda: [separate(*revolution) for revolution in zip(*readings)])
    h1, h2, h3 = readings
    profile_alone = best(lambda: np.fft.irfft(np.fft.rfft(h1 + K2 * h2 + K3 * h3) * INVERSE, n=N))
    root = pathlib.Path(__file__).resolve().parent.parent
    with tempfile.TemporaryDirectory() as folder:
        probes, out = pathlib.Path(folder, "probes"), pathlib.Path(folder, "out")
        probes.write_bytes(b"".join(part.astype("<f8").tobytes() for part in readings))
        command = ["cargo", "run", "--quiet", "--release", "-p", "trueaxis-metrology", "--example", "separation", "--"]
        values = [str(value) for value in (N, P, Q, FIRST, LAST, RATIO, probes, out)]
        ours = float(subprocess.run(command + values, cwd=root, check=True, capture_output=True, text=True).stdout)
        found = np.frombuffer(out.read_bytes(), "<f8").reshape(3, REVOLUTIONS, N)
    difference = max(np.abs(a - b).max() for a, b in zip(found, truth))
    for name, seconds in (("trueaxis", ours), ("numpy, all at once", at_once), ("numpy, one by one", one_by_one),
                          ("numpy, profile alone", profile_alone)):
        print(f"{name:20} {1e6 * seconds / REVOLUTIONS:8.2f} µs a revolution, {ours / seconds:.3f} of it ours")
    print(f"largest difference {difference:.1e} µm")
    if difference > 1e-9:
        sys.exit("the results differ")


if __name__ == "__main__":
    main()
