"""Proves the limiter's bounds in a cycle on the compiler's code of it, bit for bit.

    limiter.py CODE.ll SIZES.txt           the code of `limiter/` and the compiler's word on how its types lie in memory
    limiter.py --must-fail CODE.ll SIZES.txt FUNCTION...

For all limits C, V, a > 0 up to a sixteenth of the largest number, all bit patterns in the limiter's other fields, and all
states with |sent|, |target| up to the same and |velocity| <= V (or up to the same, where said "of any velocity"), and all
wanted corrections, infinite and not-a-number included.
"""

import argparse
import re
import sys
import time

from bitwuzla import Bitwuzla, Kind, Option, Options, Result, TermManager

from ir import Machine, Module

LIMITER = ("magnitude", "velocity", "acceleration", "open", "approach", "brake", "far", "rounding")
STATE = ("sent", "velocity", "target")
# A quarter of 2^(largest exponent + 1).
LARGE = {"float": 2.0**125, "double": 2.0**1021}


def layout(text, name, scalar):
    """Field to byte, as printed by the compiler (-Zprint-type-sizes), in memory order."""
    found = re.search(rf"type: `\S*::{name}<{scalar}>`: (\d+) bytes.*\n((?:print-type-size     .*\n)+)", text)
    if not found:
        sys.exit(f"limiter.py: found no type {name}<{scalar}> in the compiler's list, needed its layout")
    fields, place = {}, 0
    for field, size in re.findall(r"field `\.(\w+)`: (\d+) bytes", found.group(2)):
        fields[field], place = place, place + int(size)
    if place != int(found.group(1)):
        sys.exit(f"limiter.py: {name}<{scalar}> has padding, needed none")
    return fields


class Cycle:
    """One call of a function on unknown memory."""

    def __init__(self, module, sizes, function, scalar, wanted, exact):
        self.terms = TermManager()
        machine = self.machine = Machine(self.terms, module, {"f32": "float", "f64": "double"}[scalar], exact)
        fields = {"limiter": layout(sizes, "Limiter", scalar), "state": layout(sizes, "LimiterState", scalar)}
        for name, needed in (("limiter", LIMITER), ("state", STATE)):
            if set(fields[name]) != set(needed):
                sys.exit(f"limiter.py: found the fields {sorted(fields[name])}, needed {sorted(needed)}")
        large = LARGE[machine.scalar]
        for sign in (-1.0, 1.0):
            # What sums of large numbers cannot exceed.
            machine.sums.note(*(machine.number(sign * large * by) for by in (0.5, 0.5, 1.0)))
            machine.sums.note(*(machine.number(sign * large * by) for by in (1.0, 1.0, 2.0)))
        memory = {(name, byte): machine.fresh(field) for name, of in fields.items() for field, byte in of.items()}
        look = lambda name: {field: memory[name, byte] for field, byte in fields[name].items()}
        self.limits, self.before = look("limiter"), look("state")
        self.wanted = machine.fresh("wanted")
        arguments = [("limiter", 0), ("state", 0)] + [self.wanted] * wanted
        self.limited = machine.run(module.find(function), arguments, memory)
        self.after = look("state")
        machine.sums.thorough = True
        if look("limiter") != self.limits:
            sys.exit(f"limiter.py: {function} writes to its limits")

    # Words of claims.
    def at_most(self, a, b):
        return self.machine.of(Kind.FP_LEQ, a, b)

    def size(self, a):
        return self.machine.of(Kind.FP_ABS, a)

    def all(self, *claims):
        return claims[0] if len(claims) == 1 else self.machine.of(Kind.AND, *claims)

    def either(self, *claims):
        return self.machine.of(Kind.OR, *claims)

    def equal(self, a, b):
        return self.machine.of(Kind.FP_EQUAL, a, b)

    def finite(self, a):
        none = self.either(self.machine.of(Kind.FP_IS_NAN, a), self.machine.of(Kind.FP_IS_INF, a))
        return self.machine.of(Kind.NOT, none)

    def below(self, a, bound):
        """0 < a <= bound."""
        return self.all(self.machine.of(Kind.FP_GT, a, self.machine.number(0.0)), self.at_most(a, bound))

    def assumed(self, moving):
        """The premises; `moving`: of the velocity only that it is a number, as after limits were lowered in motion."""
        machine, limits, before = self.machine, self.limits, self.before
        large = machine.number(0.5 * LARGE[machine.scalar])
        fastest = large if moving else limits["velocity"]
        return machine.facts + [
            *(self.below(limits[name], large) for name in ("magnitude", "velocity", "acceleration")),
            self.at_most(self.size(before["sent"]), large),
            self.at_most(self.size(before["target"]), large),
            self.at_most(self.size(before["velocity"]), fastest),
        ]

    # Claims.
    def slope(self, narrower=False):
        """|v'| <= V"""
        bound = self.limits["velocity"]
        if narrower:
            bound = self.machine.bits.next_below(bound)
        return self.at_most(self.size(self.after["velocity"]), bound)

    def slowed(self):
        """|v'| <= max(V, |v|)"""
        now = self.size(self.after["velocity"])
        return self.either(self.slope(), self.at_most(now, self.size(self.before["velocity"])))

    def acceleration(self, narrower=False):
        """fl(v - a) <= v' <= fl(v + a), or fl|v' - v| <= a"""
        machine, a = self.machine, self.limits["acceleration"]
        if narrower:
            a = machine.bits.next_below(a)
        before, now = self.before["velocity"], self.after["velocity"]
        window = self.all(self.at_most(machine.sub(before, a), now), self.at_most(now, machine.add(before, a)))
        return self.either(window, self.at_most(self.size(machine.sub(now, before)), a))

    def numbers(self):
        """sent', v' and target' are finite"""
        return self.all(*(self.finite(value) for value in self.after.values()))

    def added(self):
        """sent' = fl(sent + v'), or v' = fl(sent' - sent)"""
        before, after = self.before["sent"], self.after["sent"]
        moved = self.machine.add(before, self.after["velocity"])
        passed = self.machine.sub(after, before)
        return self.either(self.equal(after, moved), self.equal(self.after["velocity"], passed))

    def told(self):
        """'limited' is returned exactly where sent' differs from the wanted correction"""
        same = self.equal(self.after["sent"], self.wanted)
        return self.machine.of(Kind.XOR, self.limited, same)

    def aimed(self):
        """|target'| <= C, given that open <= C"""
        holds = self.at_most(self.size(self.after["target"]), self.limits["magnitude"])
        above = self.machine.of(Kind.NOT, self.at_most(self.limits["open"], self.limits["magnitude"]))
        return self.either(holds, above)

    def rests(self):
        """target' = sent'"""
        return self.equal(self.after["target"], self.after["sent"])

    def slower(self):
        """|v'| <= |v|"""
        return self.at_most(self.size(self.after["velocity"]), self.size(self.before["velocity"]))

    def stands(self):
        """sent' = sent, v' = 0"""
        still = self.equal(self.after["velocity"], self.machine.number(0.0))
        return self.all(still, self.equal(self.after["sent"], self.before["sent"]))


# For each function: whether it takes a wanted correction, and its claims (name of the claim, whether for any velocity).
FUNCTIONS = {
    "follow": (1, [("slope", False), ("acceleration", False), ("numbers", False), ("added", False), ("told", False),
                   ("aimed", False), ("slowed", True), ("acceleration", True), ("numbers", True)]),
    "freeze": (0, [("slope", False), ("slower", True), ("acceleration", True), ("added", True), ("rests", True),
                   ("numbers", True)]),
    "hold": (0, [("stands", True), ("rests", True), ("numbers", True)]),
}
# Bounds that are not kept once they are narrower by one unit in the last place.
NARROWER = {"follow": ["slope", "acceleration"], "freeze": ["acceleration"]}


# Longest time for one claim, milliseconds; none without --minutes.
LONGEST = {}


def holds(cycle, moving, claim):
    """Whether the claim follows, for all values; None if the solver runs out of time."""
    options = Options()
    for milliseconds in LONGEST.values():
        options.set(Option.TIME_LIMIT_PER, milliseconds)
    solver = Bitwuzla(cycle.terms, options)
    for premise in cycle.assumed(moving):
        solver.assert_formula(premise)
    # A premise that nothing fulfils would prove all.
    if solver.check_sat() != Result.SAT:
        sys.exit("limiter.py: found premises that nothing fulfils")
    solver.assert_formula(cycle.machine.of(Kind.NOT, claim))
    found = solver.check_sat()
    if found == Result.UNKNOWN:
        if not LONGEST:
            sys.exit("limiter.py: the solver gave up")
        return None
    return found == Result.UNSAT


def chosen(function, full):
    """Its claims; without `full`, not the slow ones for any velocity."""
    return [(name, moving) for name, moving in FUNCTIONS[function][1] if full or function != "follow" or not moving]


def words(name, claim, moving, kept, seconds):
    """Reports a claim."""
    said = {True: "proved", False: "FAILS ", None: "open  "}[kept]
    of = getattr(Cycle, claim).__doc__ + (", of any velocity" if moving else "")
    print(f"{name:12} {said} {of}  {seconds:.1f} s", flush=True)


def cycle_of(module, sizes, name, exact):
    kind, scalar = name.split("_")[:2]
    return kind, Cycle(module, sizes, name, scalar, FUNCTIONS[kind][0], exact)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--must-fail", action="store_true", help="every FUNCTION must break a claim")
    arguments.add_argument("--full", action="store_true", help="also the slow claims: follow from any velocity")
    arguments.add_argument("--minutes", type=float, help="longest time for a claim, which then counts as open")
    arguments.add_argument("--exact", action="store_true", help="sums bit for bit, instead of by the laws of rounding")
    arguments.add_argument("code")
    arguments.add_argument("sizes")
    arguments.add_argument("functions", nargs="*", metavar="FUNCTION")
    arguments = arguments.parse_args()
    module, sizes = Module(open(arguments.code).read()), open(arguments.sizes).read()
    names = arguments.functions or [f"{kind}_{scalar}" for scalar in ("f32", "f64") for kind in FUNCTIONS]
    if arguments.minutes:
        LONGEST["claim"] = round(60_000 * arguments.minutes)
    failed = False
    for name in names:
        begun = time.process_time()
        kind, cycle = cycle_of(module, sizes, name, arguments.exact)
        broken = []
        for claim, moving in chosen(kind, arguments.full):
            since = time.process_time()
            kept = holds(cycle, moving, getattr(cycle, claim)())
            if not arguments.must_fail:
                words(name, claim, moving, kept, time.process_time() - since)
            failed |= kept is None
            broken += [claim] if kept is False else []
            if broken and arguments.must_fail:
                break
        seconds = time.process_time() - begun
        if arguments.must_fail:
            print(f"{name:28} {'breaks ' + ', '.join(broken) if broken else 'HOLDS, and must not'}  {seconds:.1f} s")
            failed |= not broken
            continue
        tried = NARROWER.get(kind, [])
        narrow = [claim for claim in tried if holds(cycle, False, getattr(cycle, claim)(narrower=True)) is not False]
        for claim in narrow:
            print(f"{name:12} FAILS: {claim} is not refused with a narrower bound, and must be")
        print(f"{name:12} {seconds:.1f} s; {len(tried) - len(narrow)} narrower bounds refused", flush=True)
        failed |= bool(broken or narrow)
    sys.exit(failed)


if __name__ == "__main__":
    main()
