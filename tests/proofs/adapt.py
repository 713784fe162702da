"""Proves the bound of a friction figure's factor on the compiler's code of its law, bit for bit.

    adapt.py CODE.ll SIZES.txt           the code of `adapt/` and the compiler's word on how its types lie in memory
    adapt.py --must-fail CODE.ll SIZES.txt FUNCTION...

For all intervals 0 < low <= 1 <= high up to a sixteenth of the largest number, all steps above zero up to the same, all bit
patterns of the factor and all errors, infinite and not-a-number included. The factor in use lies in the interval in every
cycle, whatever the state holds; so no premise about the state has to be kept from cycle to cycle.
"""

import argparse
import re
import sys
import time

from bitwuzla import Bitwuzla, Kind, Options, Result, TermManager

from ir import Machine, Module
from limiter import LARGE, layout

FIELDS = {"Bounds": ("low", "high", "step"), "Factor": ("value",)}


class Code(Machine):
    """Without divisions, so that of a product this is known, too: of two finite numbers it is a number."""

    def signed(self, a, b):
        result = super().signed(a, b)
        operands = [self.of(kind, x) for x in (a, b) for kind in (Kind.FP_IS_NAN, Kind.FP_IS_INF)]
        self.facts.append(self.of(Kind.IMPLIES, self.of(Kind.FP_IS_NAN, result), self.of(Kind.OR, *operands)))
        return result

    def operation(self, word, *rest):
        if word == "fdiv":
            sys.exit("adapt.py: found a division, needed none")
        return super().operation(word, *rest)


class Cycle:
    """One call of a function on unknown memory."""

    def __init__(self, module, sizes, function, scalar):
        self.terms = TermManager()
        machine = self.machine = Code(self.terms, module, {"f32": "float", "f64": "double"}[scalar])
        fields = {name: layout(sizes, name, scalar) for name in FIELDS}
        for name, needed in FIELDS.items():
            if set(fields[name]) != set(needed):
                sys.exit(f"adapt.py: found the fields {sorted(fields[name])}, needed {sorted(needed)}")
        large = LARGE[machine.scalar]
        for sign in (-1.0, 1.0):
            # What sums of large numbers cannot exceed.
            machine.sums.note(*(machine.number(sign * large * by) for by in (0.5, 0.5, 1.0)))
        memory = {(name, byte): machine.fresh(field) for name, of in fields.items() for field, byte in of.items()}
        look = lambda name: {field: memory[name, byte] for field, byte in fields[name].items()}
        self.bounds, self.before = look("Bounds"), look("Factor")["value"]
        self.error = machine.fresh("error")
        # The factor in use before and after.
        self.used = self.limited(self.before)
        arguments = [("Bounds", 0), ("Factor", 0)] + [self.error] * function.startswith("follow")
        self.result = machine.run(module.find(function), arguments, memory)
        self.after = look("Factor")["value"]
        machine.sums.thorough = True
        if look("Bounds") != self.bounds:
            sys.exit(f"adapt.py: {function} writes to its interval")

    def limited(self, value):
        """The scalar's `limit`: the low end for a value that is no number."""
        machine, low, high = self.machine, self.bounds["low"], self.bounds["high"]
        above = machine.of(Kind.ITE, machine.of(Kind.FP_GT, value, low), value, low)
        return machine.of(Kind.ITE, machine.of(Kind.FP_LT, above, high), above, high)

    # Words of claims.
    def at_most(self, a, b):
        return self.machine.of(Kind.FP_LEQ, a, b)

    def number(self, value):
        return self.machine.number(value)

    def all(self, *claims):
        return self.machine.of(Kind.AND, *claims)

    def either(self, *claims):
        return self.machine.of(Kind.OR, *claims)

    def equal(self, a, b):
        return self.machine.of(Kind.FP_EQUAL, a, b)

    def none(self, a):
        return self.either(self.machine.of(Kind.FP_IS_NAN, a), self.machine.of(Kind.FP_IS_INF, a))

    def assumed(self):
        machine, bounds = self.machine, self.bounds
        large, one = machine.number(0.5 * LARGE[machine.scalar]), machine.number(1.0)
        above = lambda a: machine.of(Kind.FP_GT, a, machine.number(0.0))
        return machine.facts + [
            above(bounds["low"]), self.at_most(bounds["low"], one), self.at_most(one, bounds["high"]),
            self.at_most(bounds["high"], large), above(bounds["step"]), self.at_most(bounds["step"], large),
        ]

    def inside(self, value, narrower):
        low, high = self.bounds["low"], self.bounds["high"]
        if narrower:
            high = self.machine.bits.next_below(high)
        return self.all(self.at_most(low, value), self.at_most(value, high))

    # Claims.
    def kept(self, narrower=False):
        """low <= used(factor) <= high"""
        return self.inside(self.result, narrower)

    def stays(self, narrower=False):
        """low <= factor' <= high, or the factor is unchanged because the error is no finite number"""
        same = self.machine.of(Kind.EQUAL, self.after, self.before)
        return self.either(self.inside(self.after, narrower), self.all(self.none(self.error), same))

    def slow(self, narrower=False):
        """fl(used - step) <= used' <= fl(used + step)"""
        machine, step, now = self.machine, self.bounds["step"], self.limited(self.after)
        if narrower:
            step = machine.bits.next_below(step)
        return self.all(self.at_most(machine.sub(self.used, step), now), self.at_most(now, machine.add(self.used, step)))

    def towards(self):
        """used' >= used for an error above zero, used' <= used for one below, used' = used for one that is not finite"""
        zero, now = self.machine.number(0.0), self.limited(self.after)
        up, down = self.at_most(self.used, now), self.at_most(now, self.used)
        above, below = (self.machine.of(kind, self.error, zero) for kind in (Kind.FP_GT, Kind.FP_LT))
        rises, falls = (self.either(self.machine.of(Kind.NOT, when), then) for when, then in ((above, up), (below, down)))
        rests = self.either(self.machine.of(Kind.NOT, self.none(self.error)), self.equal(now, self.used))
        return self.all(rises, falls, rests)


# For each function its claims, and those that are refused with a bound one unit in the last place narrower.
FUNCTIONS = {"follow": (["stays", "slow", "towards"], ["stays", "slow"]), "used": (["kept"], ["kept"])}


def holds(cycle, claim):
    """Whether the claim follows, for all values."""
    solver = Bitwuzla(cycle.terms, Options())
    for premise in cycle.assumed():
        solver.assert_formula(premise)
    # A premise that nothing fulfils would prove all.
    if solver.check_sat() != Result.SAT:
        sys.exit("adapt.py: found premises that nothing fulfils")
    solver.assert_formula(cycle.machine.of(Kind.NOT, claim))
    found = solver.check_sat()
    if found == Result.UNKNOWN:
        sys.exit("adapt.py: the solver gave up")
    return found == Result.UNSAT


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--must-fail", action="store_true", help="every FUNCTION must break a claim")
    arguments.add_argument("code")
    arguments.add_argument("sizes")
    arguments.add_argument("functions", nargs="*", metavar="FUNCTION")
    arguments = arguments.parse_args()
    module, sizes = Module(open(arguments.code).read()), open(arguments.sizes).read()
    names = arguments.functions or [f"{kind}_{scalar}" for scalar in ("f32", "f64") for kind in FUNCTIONS]
    failed = False
    for name in names:
        begun = time.process_time()
        kind, scalar = name.split("_")[:2]
        text = sizes
        if arguments.must_fail:
            # Only the types of this defect.
            own = name.split("_", 2)[2]
            text = re.sub(rf"`(?!\S*\b{own}::)\S*::(Bounds|Factor)<", "`other<", sizes)
        cycle = Cycle(module, text, name, scalar)
        claims, tried = FUNCTIONS[kind]
        broken = []
        for claim in claims:
            kept = holds(cycle, getattr(cycle, claim)())
            broken += [] if kept else [claim]
            if not arguments.must_fail:
                print(f"{name:12} {'proved' if kept else 'FAILS '} {getattr(Cycle, claim).__doc__}", flush=True)
        seconds = time.process_time() - begun
        if arguments.must_fail:
            print(f"{name:28} {'breaks ' + ', '.join(broken) if broken else 'HOLDS, and must not'}  {seconds:.1f} s")
            failed |= not broken
            continue
        narrow = [claim for claim in tried if holds(cycle, getattr(cycle, claim)(narrower=True))]
        for claim in narrow:
            print(f"{name:12} FAILS: {claim} is not refused with a narrower bound, and must be")
        print(f"{name:12} {seconds:.1f} s; {len(tried) - len(narrow)} narrower bounds refused", flush=True)
        failed |= bool(broken or narrow)
    sys.exit(failed)


if __name__ == "__main__":
    main()
