"""Proves in real arithmetic that the braking law of the limiter keeps |c| <= C for ever.

U(d) = min over n >= 1 of f(n, d), f(n, d) = d/n + a (n - 1)/2: the largest speed from which whole cycles of deceleration a
stop within d. With d = C - c the room above, before the cycle, and v' the change in it, the invariant is

    v' <= U(d),   hence   c' <= C   and   v' - a <= U(d - v')

so that braking with a is always enough in the next cycle. The room below is its mirror image. Integers n are real numbers
here, with what is used of them as premises; "for every n" is the instance that the negated claim names.
"""

import sys

import z3

a, v, w, d, top, n, m, up, low = z3.Reals("a v w d V n m up low")
ABOVE = [a > 0, top > 0]


def f(count, room):
    return room / count + a * (count - 1) / 2


def limit(x, least, most):
    """The scalar's `limit`."""
    x = z3.If(x > least, x, least)
    return z3.If(x < most, x, most)


# Choice of the law with room up >= 0 above and low >= 0 below and the last change w: anything between the bounds.
fastest = z3.If(z3.If(up < w + a, up, w + a) > w - a, z3.If(up < w + a, up, w + a), w - a)
slowest = z3.If(z3.If(-low > w - a, -low, w - a) < w + a, z3.If(-low > w - a, -low, w - a), w + a)
frozen = w - limit(w, -a, a)
kept = [up >= 0, low >= 0, w - a <= up, w + a >= -low]

# name: (premises, claim, premise without which it must fail).
CLAIMS = {
    "a stop fits in the next cycle": ([n >= 1, v <= f(n + 1, d)], v - a <= f(n, d - v), 1),
    "no step beyond the limit": ([v <= f(1, d)], d - v >= 0, 0),
    "the cycles chosen stop fastest (n (n+1)/2 >= d/a, (n-1) n/2 <= d/a), against more": (
        [d > 0, n >= 1, m >= n + 1, n * (n + 1) * a >= 2 * d], f(m, d) >= f(n, d), 3),
    "the same against fewer": ([d > 0, m >= 1, m <= n - 1, n * (n - 1) * a <= 2 * d], f(m, d) >= f(n, d), 3),
    "n at least (sqrt(1 + 8d/a) - 1)/2 is n (n+1)/2 at least d/a": (
        [d > 0, n >= 1, m >= 1, m * m == 1 + 8 * d / a, n >= (m - 1) / 2], n * (n + 1) * a >= 2 * d, 4),
    "below C - V - V^2/2a the slope itself is safe": ([n >= 1, d >= top + top * top / (2 * a)], top <= f(n, d), 1),
    "the law stays below the room above": (kept + [v <= fastest], v <= up, 2),
    "the law stays below the room below": (kept + [v >= slowest], v >= -low, 3),
    "there is always a change that it may choose": (kept, slowest <= fastest, 0),
    "freezing stays below the room above": (kept + [v == frozen], v <= up, 2),
    "freezing stays below the room below": (kept + [v == frozen], v >= -low, 3),
    "holding stays within": (kept + [v == 0], z3.And(v <= up, v >= -low), 0),
}


def holds(premises, claim):
    solver = z3.Solver()
    solver.set("timeout", 60_000)
    solver.add(*ABOVE, *premises)
    if solver.check() != z3.sat:
        sys.exit("magnitude.py: found premises that nothing fulfils")
    solver.add(z3.Not(claim))
    found = solver.check()
    if found == z3.unknown:
        sys.exit("magnitude.py: the solver gave up")
    return found == z3.unsat


failed = False
for name, (premises, claim, needed) in CLAIMS.items():
    proved = holds(premises, claim)
    without = holds(premises[:needed] + premises[needed + 1:], claim)
    verdict = "FAILS" if not proved else "holds without its premise, and must not" if without else "proved"
    print(f"magnitude    {verdict} {name}")
    failed |= verdict != "proved"
sys.exit(failed)
