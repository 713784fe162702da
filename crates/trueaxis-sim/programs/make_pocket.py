#!/usr/bin/env python3
"""Writes pocket-3d.ngc, a small pocket with every kind of move in space.

Helical entry, a flat pass with rounded corners, a ramp, a floor whose waves are chains of G18 and G19 arcs, and a
wall finish by a helix. Usage: python3 make_pocket.py > pocket-3d.ngc
"""

LENGTH, WIDTH, CORNER = 40.0, 24.0, 4.0  # mm, path of the tool centre
DEPTH = -4.0
WAVE_RADIUS, WAVE_CHORD = 5.0, 4.0  # one wave: two arcs of this radius over this chord
LINES = 5


def word(letter, value):
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return f"{letter}{'0' if text == '-0' else text}"


def words(code, **values):
    return " ".join([code] + [word(letter, value) for letter, value in values.items()]).strip()


def helix(out):
    out.append("(helical entry, two turns and a half)")
    out.append(words("G0", X=4, Y=0))
    out.append(words("G1", Z=0, F=600))
    out.append(words("G3", X=-4, Y=0, Z=DEPTH, I=-4, J=0, P=3, F=900))


def flat(out):
    x, y, r = LENGTH / 2, WIDTH / 2, CORNER
    out.append("(flat pass, climb, rounded corners)")
    out.append(words("G1", X=-4, Y=-y + 8, F=1500))
    out.append(words("G3", X=4, Y=-y, I=8, J=0))
    out.append(words("G1", X=x - r, Y=-y))
    out.append(words("G3", X=x, Y=-y + r, R=r))
    out.append(words("G1", Y=y - r))
    out.append(words("G3", X=x - r, Y=y, R=r))
    out.append(words("G1", X=-x + r))
    out.append(words("G3", X=-x, Y=y - r, R=r))
    out.append(words("G1", Y=-y + r))
    out.append(words("G3", X=-x + r, Y=-y, R=r))
    out.append(words("G1", X=4))


def wavy(out):
    x, half = LENGTH / 2 - 2, WAVE_CHORD / 2
    sag = (WAVE_RADIUS**2 - half**2) ** 0.5
    waves = int(2 * x / (2 * WAVE_CHORD))
    out.append("(ramp to the wavy floor)")
    y = -WIDTH / 2 + 2
    out.append(words("G1", X=-x, Y=y, Z=DEPTH + 2))
    for line in range(LINES):
        sign = 1 if line % 2 == 0 else -1
        position = -x * sign
        out.append(f"(floor line {line + 1}: waves in ZX)")
        out.append("G18")
        for _ in range(waves):
            for code, up in (("G3", 1), ("G2", -1)):
                # Counter-clockwise in G18 is from Z to X: over the top towards +X. The sense changes with the direction.
                code = code if sign > 0 else {"G2": "G3", "G3": "G2"}[code]
                position += sign * WAVE_CHORD
                out.append(words(code, X=position, Z=DEPTH + 2, I=sign * half, K=-up * sag))
        if line < LINES - 1:
            out.append("(step over on an arc in YZ)")
            step = (WIDTH - 4) / (LINES - 1)
            y += step
            out.append("G19")
            out.append(words("G2", Y=y, Z=DEPTH + 2, J=step / 2, K=-2))
    out.append("G17")


def wall(out):
    x = LENGTH / 2
    out.append("(wall: rising helix, one turn and a half)")
    out.append(words("G1", X=0, Y=WIDTH / 2, Z=DEPTH + 1))
    out.append(words("G2", X=0, Y=-WIDTH / 2, Z=0, I=0, J=-WIDTH / 2, P=2))
    out.append(words("G1", X=x / 2, Y=0, Z=1))


def main():
    out = ["; Small pocket in space; made by make_pocket.py.", "G17 G21 G90 G91.1 G94", "G0 Z10"]
    helix(out)
    flat(out)
    wavy(out)
    wall(out)
    out += ["G0 Z10", "M2"]
    print("\n".join(out))


if __name__ == "__main__":
    main()
