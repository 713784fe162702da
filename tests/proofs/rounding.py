"""Proves the laws of rounded sums that `rounded.Sums` uses, for the sums of IEEE 754, bit for bit.

For all operands of a format of nine bits, in which a solver can do it within a minute; the laws are the same words for
every width, and those of IEEE 754 whatever the width. Half precision (5 11) takes minutes:

    rounding.py [EXPONENT SIGNIFICAND]
"""

import sys
import time

from bitwuzla import Bitwuzla, Kind, Options, Result, TermManager

import ir
from ir import Machine, Module
from rounded import Sums

exponent, significand = map(int, sys.argv[1:]) if len(sys.argv) == 3 else (4, 5)


class Format(Machine):
    """A machine of any width."""

    def number(self, value):
        if value != 0.0:
            raise SystemExit("rounding.py: found a constant that is not zero, needed none")
        return self.bits.none


ir.WIDTHS["proved"] = (exponent, significand)


def laws(flaw):
    """The laws of two sums, and the premises that they are sums; `flaw` plants a wrong one."""
    terms = TermManager()
    machine = Format(terms, Module(""), "proved", exact=True)
    x, y, z, w = (machine.fresh(name) for name in "xyzw")
    claims = []
    sums = Sums(machine.of, machine.fresh, claims, machine.number(0.0))
    sums.thorough = True
    pairs = [(x, y), (z, w)]
    results = [machine.exact_sum(*pair) for pair in pairs]
    for pair, result in zip(pairs, results):
        sums.law(*pair, result)
        sums.note(*pair, result, plain=False)
    if flaw:
        # Larger operands give larger sums, but not strictly.
        claims.append(machine.of(Kind.IMPLIES, machine.of(Kind.AND, machine.of(Kind.FP_LT, x, z), machine.of(Kind.EQUAL, y, w),
                                 machine.of(Kind.NOT, machine.of(Kind.FP_IS_NAN, results[0]))),
                                 machine.of(Kind.FP_LT, results[0], results[1])))
    return terms, machine.facts, claims


for flaw in (False, True):
    begun = time.monotonic()
    terms, premises, claims = laws(flaw)
    solver = Bitwuzla(terms, Options())
    for premise in premises:
        solver.assert_formula(premise)
    solver.assert_formula(terms.mk_term(Kind.NOT, [terms.mk_term(Kind.AND, claims)]))
    proved = solver.check_sat() == Result.UNSAT
    word = "planted law refused" if flaw and not proved else "proved" if proved and not flaw else "FAILS"
    print(f"rounding     {word}: {len(claims)} laws of sums, {exponent + significand} bits  {time.monotonic() - begun:.1f} s")
    if proved == flaw:
        sys.exit(1)
