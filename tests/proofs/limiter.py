"""Proves the limiter's bounds in a cycle on the compiler's code of it, bit for bit.

    limiter.py CODE.ll SIZES.txt           the code of `limiter/` and the compiler's word on how its types lie in memory
    limiter.py --must-fail CODE.ll SIZES.txt FUNCTION...

For all limits C, V, a > 0 up to a sixteenth of the largest number, all bit patterns in the limiter's other fields, and all
states with |sent|, |target| up to the same and |velocity| <= V (or up to the same, where said "of any velocity"), and all
wanted corrections, infinite and not-a-number included.
"""

from bitwuzla import Kind

from frame import LARGE, Call, arguments, prove
from ir import Machine

TYPES = {
    "Limiter": ("magnitude", "velocity", "acceleration", "open", "approach", "brake", "far", "rounding"),
    "LimiterState": ("sent", "velocity", "target"),
}


class Cycle(Call):
    def __init__(self, module, sizes, function, scalar, wanted, exact):
        machine = lambda terms, module, scalar: Machine(terms, module, scalar, exact)
        super().__init__(machine, module, sizes, function, scalar, TYPES, wanted)
        self.limits, self.wanted, self.limited = self.settings, self.value, self.result

    def assumed(self, moving=False):
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

    def aims_finite(self):
        """sent', v' and target' are finite, given that open <= C"""
        return self.either(self.numbers(), self.beyond())

    def beyond(self):
        """open > C, which no limiter has that is made from settings."""
        return self.denied(self.at_most(self.limits["open"], self.limits["magnitude"]))

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
        return self.either(holds, self.beyond())

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
    "follow": (1, [("slope", False), ("acceleration", False), ("aims_finite", False), ("added", False), ("told", False),
                   ("aimed", False), ("slowed", True), ("acceleration", True), ("aims_finite", True)]),
    "freeze": (0, [("slope", False), ("slower", True), ("acceleration", True), ("added", True), ("rests", True),
                   ("numbers", True)]),
    "hold": (0, [("stands", True), ("rests", True), ("numbers", True)]),
}
# Bounds that are not kept once they are narrower by one unit in the last place.
NARROWER = {"follow": ["slope", "acceleration"], "freeze": ["acceleration"]}


def chosen(full):
    """The claims of each function; without `full`, not the slow ones for any velocity."""
    claims = {}
    for function, (_, own) in FUNCTIONS.items():
        own = [(claim, moving) for claim, moving in own if full or function != "follow" or not moving]
        claims[function] = [(claim, (moving,), ", of any velocity" if moving else "") for claim, moving in own]
    return claims


def main():
    parser = arguments(__doc__)
    parser.add_argument("--full", action="store_true", help="also the slow claims: follow from any velocity")
    parser.add_argument("--minutes", type=float, help="longest time for a claim, which then counts as open")
    parser.add_argument("--exact", action="store_true", help="sums bit for bit, instead of by the laws of rounding")
    given = parser.parse_args()
    cycle = lambda module, sizes, name, kind, scalar: Cycle(module, sizes, name, scalar, FUNCTIONS[kind][0], given.exact)
    prove(given, chosen(given.full), NARROWER, cycle, given.minutes)


if __name__ == "__main__":
    main()
