#!/usr/bin/env python3
"""Quantiles of Student's and the chi-squared distribution with 30 digits: tests/reference/uncertainty.py > uncertainty.json

Needs mpmath. student: k with P(|t_nu| <= k) = p, by the integral of the density. chi_squared: x with
P(chi2_nu <= x) = p.
"""
import json
import mpmath as mp

mp.mp.dps = 30


def where(rising, low, high, digits=100):
    """Where a rising function is zero, by halving."""
    low, high = mp.mpf(low), mp.mpf(high)
    for _ in range(digits):
        middle = (low + high) / 2
        low, high = (middle, high) if rising(middle) < 0 else (low, middle)
    return (low + high) / 2


def student(p, nu):
    if nu == mp.inf:
        return mp.sqrt(2) * mp.erfinv(p)
    inside = lambda k: 1 - mp.betainc(nu / 2, mp.mpf(1) / 2, 0, nu / (nu + k * k), regularized=True)
    return where(lambda k: inside(k) - p, 0, 400)


def chi_squared(p, nu):
    inside = lambda x: mp.gammainc(nu / 2, 0, x / 2, regularized=True)
    return where(lambda x: inside(x) - p, 0, 20 * nu + 60)


nus = [1, 2, 3, 4, 5, 8, 10, 16, 20, 50, 100, 1000]
print(json.dumps({
    "student": [[p, nu, float(student(mp.mpf(p), mp.mpf(nu)))] for p in ("0.5", "0.95", "0.99") for nu in nus]
    + [[p, None, float(student(mp.mpf(p), mp.inf))] for p in ("0.5", "0.95", "0.99")],
    "chi_squared": [[p, nu, float(chi_squared(mp.mpf(p), mp.mpf(nu)))]
                    for p in ("0.05", "0.5", "0.95", "0.99") for nu in ("1", "1.7", "2", "2.3", "3", "10", "60")],
}, indent=1))
