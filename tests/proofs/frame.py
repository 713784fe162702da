"""What the proofs on the compiler's code have in common: the layout of its types, a call on unknown memory, the words of claims,
and the order in which claims are proved, refused with narrower bounds, and broken by planted defects.
"""

import argparse
import re
import sys
import time

from bitwuzla import Bitwuzla, Kind, Option, Options, Result, TermManager

from ir import Module

# A quarter of 2^(largest exponent + 1).
LARGE = {"float": 2.0**125, "double": 2.0**1021}


def layout(text, name, scalar):
    """Field to byte, as printed by the compiler (-Zprint-type-sizes), in memory order."""
    found = re.search(rf"type: `\S*::{name}<{scalar}>`: (\d+) bytes.*\n((?:print-type-size     .*\n)+)", text)
    if not found:
        sys.exit(f"proofs: found no type {name}<{scalar}> in the compiler's list, needed its layout")
    fields, place = {}, 0
    for field, size in re.findall(r"field `\.(\w+)`: (\d+) bytes", found.group(2)):
        fields[field], place = place, place + int(size)
    if place != int(found.group(1)):
        sys.exit(f"proofs: {name}<{scalar}> has padding, needed none")
    return fields


class Call:
    """One call of a function on unknown memory. `types`: name of each argument's type to its fields; the first is not written."""

    def __init__(self, machine_of, module, sizes, function, scalar, types, value):
        self.terms = TermManager()
        machine = self.machine = machine_of(self.terms, module, {"f32": "float", "f64": "double"}[scalar])
        fields = {name: layout(sizes, name, scalar) for name in types}
        for name, needed in types.items():
            if set(fields[name]) != set(needed):
                sys.exit(f"proofs: found the fields {sorted(fields[name])}, needed {sorted(needed)}")
        large = LARGE[machine.scalar]
        for sign in (-1.0, 1.0):
            # What sums of large numbers cannot exceed.
            machine.sums.note(*(machine.number(sign * large * by) for by in (0.5, 0.5, 1.0)))
            machine.sums.note(*(machine.number(sign * large * by) for by in (1.0, 1.0, 2.0)))
        memory = {(name, byte): machine.fresh(field) for name, of in fields.items() for field, byte in of.items()}
        look = lambda name: {field: memory[name, byte] for field, byte in fields[name].items()}
        settings, state = types
        self.settings, self.before = look(settings), look(state)
        self.value = machine.fresh("value")
        arguments = [(name, 0) for name in types] + [self.value] * value
        self.result = machine.run(module.find(function), arguments, memory)
        self.after = look(state)
        machine.sums.thorough = True
        if look(settings) != self.settings:
            sys.exit(f"proofs: {function} writes to its {settings}")

    # Words of claims.
    def at_most(self, a, b):
        return self.machine.of(Kind.FP_LEQ, a, b)

    def size(self, a):
        return self.machine.of(Kind.FP_ABS, a)

    def all(self, *claims):
        return claims[0] if len(claims) == 1 else self.machine.of(Kind.AND, *claims)

    def either(self, *claims):
        return self.machine.of(Kind.OR, *claims)

    def denied(self, claim):
        return self.machine.of(Kind.NOT, claim)

    def equal(self, a, b):
        return self.machine.of(Kind.FP_EQUAL, a, b)

    def finite(self, a):
        return self.denied(self.either(self.machine.of(Kind.FP_IS_NAN, a), self.machine.of(Kind.FP_IS_INF, a)))

    def below(self, a, bound):
        """0 < a <= bound."""
        return self.all(self.machine.of(Kind.FP_GT, a, self.machine.number(0.0)), self.at_most(a, bound))


def holds(call, claim, premises, minutes):
    """Whether the claim follows, for all values; None if the solver runs out of time."""
    options = Options()
    if minutes:
        options.set(Option.TIME_LIMIT_PER, round(60_000 * minutes))
    solver = Bitwuzla(call.terms, options)
    for premise in premises:
        solver.assert_formula(premise)
    # A premise that nothing fulfils would prove all.
    if solver.check_sat() != Result.SAT:
        sys.exit("proofs: found premises that nothing fulfils")
    solver.assert_formula(call.denied(claim))
    found = solver.check_sat()
    if found == Result.UNKNOWN and not minutes:
        sys.exit("proofs: the solver gave up")
    return None if found == Result.UNKNOWN else found == Result.UNSAT


def arguments(description):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--must-fail", action="store_true", help="every FUNCTION must break a claim")
    parser.add_argument("code")
    parser.add_argument("sizes")
    parser.add_argument("functions", nargs="*", metavar="FUNCTION")
    return parser


def prove(given, functions, narrower, call_of, minutes=None):
    """Proves the claims of all functions, or of those named; exits with 1 unless all is as it must be.

    `functions`: kind to its claims, each the name of a method of the call and the further premises it takes (the arguments of
    `assumed`, and their words); `narrower`: kind to the claims that are refused with a bound one unit in the last place narrower.
    """
    module, sizes = Module(open(given.code).read()), open(given.sizes).read()
    names = given.functions or [f"{kind}_{scalar}" for scalar in ("f32", "f64") for kind in functions]
    failed = False
    for name in names:
        begun = time.process_time()
        kind, scalar = name.split("_")[:2]
        call = call_of(module, sizes, name, kind, scalar)
        broken = []
        for claim, assumed, words in functions[kind]:
            since = time.process_time()
            kept = holds(call, getattr(call, claim)(), call.assumed(*assumed), minutes)
            if not given.must_fail:
                said = {True: "proved", False: "FAILS ", None: "open  "}[kept]
                print(f"{name:12} {said} {getattr(type(call), claim).__doc__}{words}  {time.process_time() - since:.1f} s", flush=True)
            failed |= kept is None
            broken += [claim] if kept is False else []
            if broken and given.must_fail:
                break
        seconds = time.process_time() - begun
        if given.must_fail:
            print(f"{name:28} {'breaks ' + ', '.join(broken) if broken else 'HOLDS, and must not'}  {seconds:.1f} s")
            failed |= not broken
            continue
        tried = narrower.get(kind, [])
        narrow = [claim for claim in tried if holds(call, getattr(call, claim)(narrower=True), call.assumed(), minutes) is not False]
        for claim in narrow:
            print(f"{name:12} FAILS: {claim} is not refused with a narrower bound, and must be")
        print(f"{name:12} {seconds:.1f} s; {len(tried) - len(narrow)} narrower bounds refused", flush=True)
        failed |= bool(broken or narrow)
    sys.exit(failed)
