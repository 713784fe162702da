"""Numbers of floating point as a solver sees them: their order on their bits, their sums by the laws of rounding."""

from bitwuzla import Kind


class Bits:
    """Comparisons and signs of numbers on their bits, which are cheaper for a solver than its floating-point ones."""

    def __init__(self, terms, exponent, significand):
        self.terms, self.width, self.fraction = terms, exponent + significand, significand - 1
        self.sort = terms.mk_bv_sort(self.width)
        self.top = self.value(1 << (self.width - 1))
        self.endless = self.value(((1 << exponent) - 1) << self.fraction)
        self.none = self.value(0)
        self.words = {
            Kind.FP_IS_NAN: lambda a: self.of(Kind.BV_UGT, self.size(a), self.endless),
            Kind.FP_IS_INF: lambda a: self.of(Kind.EQUAL, self.size(a), self.endless),
            Kind.FP_IS_ZERO: lambda a: self.of(Kind.EQUAL, self.size(a), self.none),
            Kind.FP_IS_NEG: lambda a: self.both(self.negative(a), self.of(Kind.NOT, self.is_nan(a))),
            Kind.FP_IS_POS: lambda a: self.both(self.of(Kind.NOT, self.negative(a)), self.of(Kind.NOT, self.is_nan(a))),
            Kind.FP_NEG: lambda a: self.of(Kind.BV_XOR, a, self.top),
            Kind.FP_ABS: self.size,
            Kind.FP_LEQ: lambda a, b: self.ordered(Kind.BV_ULE, a, b),
            Kind.FP_LT: lambda a, b: self.ordered(Kind.BV_ULT, a, b),
            Kind.FP_GEQ: lambda a, b: self.ordered(Kind.BV_UGE, a, b),
            Kind.FP_GT: lambda a, b: self.ordered(Kind.BV_UGT, a, b),
            Kind.FP_EQUAL: lambda a, b: self.ordered(Kind.EQUAL, a, b),
        }

    def of(self, kind, *arguments):
        return self.terms.mk_term(kind, list(arguments))

    def value(self, bits):
        return self.terms.mk_bv_value(self.sort, bits)

    def both(self, *conditions):
        return self.of(Kind.AND, *conditions)

    def negative(self, a):
        return self.of(Kind.BV_UGE, a, self.top)

    def size(self, a):
        return self.of(Kind.BV_AND, a, self.of(Kind.BV_NOT, self.top))

    def is_nan(self, a):
        return self.words[Kind.FP_IS_NAN](a)

    def place(self, a):
        """Ascends with the number; of both zeros the same."""
        return self.of(Kind.ITE, self.negative(a), self.of(Kind.BV_NEG, a), self.of(Kind.BV_OR, a, self.top))

    def ordered(self, kind, a, b):
        numbers = [self.of(Kind.NOT, self.is_nan(x)) for x in (a, b)]
        return self.both(*numbers, self.of(kind, self.place(a), self.place(b)))

    def next_below(self, a):
        """The next number towards zero, of one above zero."""
        return self.of(Kind.BV_SUB, a, self.value(1))


class Sums:
    """Rounded sums by their laws: each new one is put in order with all before it."""

    def __init__(self, of, fresh, facts, zero):
        self.of, self.fresh, self.facts, self.zero, self.known = of, fresh, facts, zero, []
        self.thorough = False

    def sum(self, x, y):
        for a, b, result, _ in self.known:
            if (a, b) in ((x, y), (y, x)):
                return result
        result = self.fresh("sum")
        self.law(x, y, result)
        self.note(x, y, result, plain=False)
        return result

    def note(self, x, y, result, plain=True):
        """`result` is the sum of the two; `plain`: three constants."""
        for other in self.known:
            # Within the code, sums that have nothing in common need no order.
            if self.thorough or plain or other[3] or any(p == q for p in (x, y) for q in other[:2]):
                self.ascends((x, y, result), other[:3])
                self.ascends(other[:3], (x, y, result))
        self.known.append((x, y, result, plain))

    def given(self, premises, claim):
        self.facts.append(self.of(Kind.IMPLIES, self.of(Kind.AND, *premises) if len(premises) > 1 else premises[0], claim))

    def law(self, x, y, result):
        """Laws of one sum: when it is not a number, infinities, and x + 0 = x."""
        of, no = self.of, lambda kind, a: self.of(Kind.NOT, self.of(kind, a))
        for a, b in ((x, y), (y, x)):
            self.facts.append(of(Kind.IMPLIES, of(Kind.FP_IS_NAN, a), of(Kind.FP_IS_NAN, result)))
            self.given([of(Kind.FP_IS_INF, a), no(Kind.FP_IS_INF, b), no(Kind.FP_IS_NAN, b)], of(Kind.EQUAL, result, a))
            numbers = [no(Kind.FP_IS_NAN, a), no(Kind.FP_IS_INF, a), no(Kind.FP_IS_NAN, b)]
            up = of(Kind.OR, of(Kind.FP_IS_POS, b), of(Kind.FP_IS_ZERO, b))
            down = of(Kind.OR, of(Kind.FP_IS_NEG, b), of(Kind.FP_IS_ZERO, b))
            self.given([*numbers, up], of(Kind.FP_LEQ, a, result))
            self.given([*numbers, down], of(Kind.FP_LEQ, result, a))
        # The sign is that of the exact sum: an underflowing sum is exact.
        numbers = [no(Kind.FP_IS_NAN, a) for a in (x, y, result)]
        zero, opposite = self.zero, of(Kind.FP_NEG, y)
        for kind in (Kind.FP_LEQ, Kind.FP_GEQ):
            self.given([*numbers, of(kind, x, opposite)], of(kind, result, zero))
        minus_zero = lambda a: of(Kind.AND, of(Kind.FP_IS_ZERO, a), of(Kind.FP_IS_NEG, a))
        self.given([minus_zero(result)], of(Kind.AND, minus_zero(x), minus_zero(y)))
        finite = [no(kind, a) for a in (x, y) for kind in (Kind.FP_IS_NAN, Kind.FP_IS_INF)]
        self.given(finite, no(Kind.FP_IS_NAN, result))

    def ascends(self, lower, upper):
        """Larger operands, larger sum, whichever way round they are added."""
        (x, y, s), (z, w, t) = lower, upper
        numbers = [self.of(Kind.NOT, self.of(Kind.FP_IS_NAN, a)) for a in (s, t)]
        for p, q in ((z, w), (w, z)):
            self.given([self.of(Kind.FP_LEQ, x, p), self.of(Kind.FP_LEQ, y, q), *numbers], self.of(Kind.FP_LEQ, s, t))
