"""Proves the bound of a friction figure's factor on the compiler's code of its law, bit for bit.

    adapt.py CODE.ll SIZES.txt           the code of `adapt/` and the compiler's word on how its types lie in memory
    adapt.py --must-fail CODE.ll SIZES.txt FUNCTION...

For all intervals 0 < low <= 1 <= high up to a sixteenth of the largest number, all steps above zero up to the same, all bit
patterns of the factor and all errors, infinite and not-a-number included. The factor in use lies in the interval in every
cycle, whatever the state holds; so no premise about the state has to be kept from cycle to cycle.
"""

import re
import sys

from bitwuzla import Kind

from frame import LARGE, Call, arguments, prove
from ir import Machine

TYPES = {"Bounds": ("low", "high", "step"), "Factor": ("value",)}


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


class Cycle(Call):
    def __init__(self, module, sizes, function, scalar):
        super().__init__(Code, module, sizes, function, scalar, TYPES, function.startswith("follow"))
        self.bounds, self.error = self.settings, self.value
        # The factor in use before and after.
        self.before, self.after = self.before["value"], self.after["value"]
        self.used, self.now = self.limited(self.before), self.limited(self.after)

    def limited(self, value):
        """The scalar's `limit`: the low end for a value that is no number."""
        machine, low, high = self.machine, self.bounds["low"], self.bounds["high"]
        above = machine.of(Kind.ITE, machine.of(Kind.FP_GT, value, low), value, low)
        return machine.of(Kind.ITE, machine.of(Kind.FP_LT, above, high), above, high)

    def assumed(self):
        machine, bounds = self.machine, self.bounds
        large, one = machine.number(0.5 * LARGE[machine.scalar]), machine.number(1.0)
        return machine.facts + [
            self.below(bounds["low"], one), self.at_most(one, bounds["high"]),
            self.at_most(bounds["high"], large), self.below(bounds["step"], large),
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
        return self.either(self.inside(self.after, narrower), self.all(self.denied(self.finite(self.error)), same))

    def slow(self, narrower=False):
        """fl(used - step) <= used' <= fl(used + step)"""
        machine, step, now = self.machine, self.bounds["step"], self.now
        if narrower:
            step = machine.bits.next_below(step)
        return self.all(self.at_most(machine.sub(self.used, step), now), self.at_most(now, machine.add(self.used, step)))

    def towards(self):
        """used' >= used for an error above zero, used' <= used for one below, used' = used for one that is not finite"""
        zero, now = self.machine.number(0.0), self.now
        up, down = self.at_most(self.used, now), self.at_most(now, self.used)
        above, below = (self.machine.of(kind, self.error, zero) for kind in (Kind.FP_GT, Kind.FP_LT))
        rises, falls = (self.either(self.denied(when), then) for when, then in ((above, up), (below, down)))
        rests = self.either(self.finite(self.error), self.equal(now, self.used))
        return self.all(rises, falls, rests)


CLAIMS = {"follow": ["stays", "slow", "towards"], "used": ["kept"]}
# Bounds that are not kept once they are narrower by one unit in the last place.
NARROWER = {"follow": ["stays", "slow"], "used": ["kept"]}


def main():
    given = arguments(__doc__).parse_args()

    def cycle(module, sizes, name, _kind, scalar):
        if given.must_fail:
            # Only the types of this defect.
            own = name.split("_", 2)[2]
            sizes = re.sub(rf"`(?!\S*\b{own}::)\S*::(Bounds|Factor)<", "`other<", sizes)
        return Cycle(module, sizes, name, scalar)

    prove(given, {kind: [(claim, (), "") for claim in claims] for kind, claims in CLAIMS.items()}, NARROWER, cycle)


if __name__ == "__main__":
    main()
