#!/usr/bin/env python3
"""Monotone cubic interpolation by SciPy (PchipInterpolator), the reference for the Rust code.

Usage: pchip.py > pchip.csv        needs scipy (pchip.csv was made with 1.17.1)

Three grids: equidistant; free; two points. Rows `grid,knot,q,value,`: the given points. Rows `grid,at,q,value,slope`:
SciPy's value and slope there. Every number is the shortest decimal of its double.
"""

import math
import random

from scipy.interpolate import PchipInterpolator

GRIDS = {
    # mm and mm of error: monotone runs, extremes, a flat, a jump.
    "equidistant": [-30.0 + 5.0 * i for i in range(13)],
    "free": [0.0, 0.5, 2.0, 2.25, 7.0, 7.125, 20.0, 50.0, 51.0, 90.0],
    "two": [-1.0, 3.0],
}


def values(name, grid):
    generator = random.Random(name)
    found = [round(0.02 * math.sin(0.11 * q) + 0.01 * (generator.random() - 0.5), 6) for q in grid]
    if len(found) > 6:
        found[4] = found[3]
        found[6] += 0.05
    return found


def main():
    print("grid,kind,q_mm,value_mm,slope")
    for name, grid in GRIDS.items():
        given = values(name, grid)
        curve = PchipInterpolator(grid, given)
        derivative = curve.derivative()
        for q, value in zip(grid, given):
            print(f"{name},knot,{q!r},{value!r},")
        count = 60
        for i in range(count + 1):
            q = grid[0] + (grid[-1] - grid[0]) * i / count
            print(f"{name},at,{q!r},{float(curve(q))!r},{float(derivative(q))!r}")


if __name__ == "__main__":
    main()
