"""LLVM code of a loop-free function as terms of SMT floating point.

Exact: negation, absolute value, comparisons, selections, jumps, loads and stores. Of the rest only this is known:

- a sum or difference rounds to nearest: it ascends with each operand, x + 0 = x, and it is no number only where an operand
  is none or two infinities cancel (`rounded.Sums`; `rounding.py` proves these of every bit pattern);
- a product or quotient has its sign, or is not a number;
- a square root or a number from an integer is anything.

What holds of such a function holds of the true one, however its products and roots are rounded. With `exact`, sums are
those of IEEE 754 bit for bit, which takes a solver minutes instead of a second. Code that is none of these is refused.
"""

import re
import struct

from bitwuzla import Kind, RoundingMode

from rounded import Bits, Sums

NAME = r'(?:[%@](?:"[^"]*"|[-\w$.]+))'
WIDTHS = {"float": (8, 24), "double": (11, 53)}
IGNORED = ("llvm.experimental.noalias.scope.decl", "llvm.assume", "llvm.lifetime", "llvm.dbg")
COMPARISONS = {"eq": Kind.FP_EQUAL, "gt": Kind.FP_GT, "ge": Kind.FP_GEQ, "lt": Kind.FP_LT, "le": Kind.FP_LEQ}
# Unordered predicates as negations of ordered ones.
NEGATED = {"ueq": ("one",), "ugt": ("ole",), "uge": ("olt",), "ult": ("oge",), "ule": ("ogt",), "une": ("oeq",)}


class Unknown:
    """An unknown integer."""


class Module:
    """Functions of a text of LLVM code: name to (parameters, blocks in order)."""

    def __init__(self, text):
        self.functions = {}
        for found in re.finditer(r"^define [^\n]*?(@\S+?)\(([^\n]*)\)[^\n]*\{\n(.*?)^\}", text, re.M | re.S):
            name, parameters, body = found.groups()
            names = re.findall(rf"({NAME})(?:,|$)", parameters)
            self.functions[name.strip('@"')] = (names, blocks(body))

    def find(self, part):
        """The one function whose name contains `part`."""
        [name] = [name for name in self.functions if part in name]
        return name


def read(pattern, text):
    """The groups of a pattern that the whole text must be."""
    found = re.fullmatch(pattern, text)
    if not found:
        raise SystemExit(f"ir.py: found {text!r}, needed {pattern}")
    return found.groups()


def blocks(body):
    """Label to instructions, in the order of the text."""
    found, label = {}, None
    for line in body.splitlines():
        line = re.sub(r"\s*;.*$", "", line).rstrip()
        if not line.strip():
            continue
        if not line.startswith(" "):
            label = line.rstrip(":").strip('"')
            found[label] = []
        else:
            if label is None:
                label = "0"
                found[label] = []
            found[label].append(line.strip())
    return found


class Machine:
    """Runs functions on terms; memory is {(pointer, byte): term}."""

    def __init__(self, terms, module, scalar, exact=False):
        self.terms, self.module, self.exact, self.facts = terms, module, exact, []
        self.scalar = scalar
        self.exponent, self.significand = WIDTHS[scalar]
        self.bytes = (self.exponent + self.significand) // 8
        self.bits = Bits(terms, self.exponent, self.significand)
        self.nearest = terms.mk_rm_value(RoundingMode.RNE)
        self.count = 0
        self.sums = Sums(self.of, self.fresh, self.facts, self.number(0.0))

    # Terms.
    def fresh(self, name):
        self.count += 1
        return self.terms.mk_const(self.bits.sort, f"{name}.{self.count}")

    def of(self, kind, *arguments):
        if kind in self.bits.words:
            return self.bits.words[kind](*arguments)
        return self.terms.mk_term(kind, list(arguments))

    def number(self, value):
        """A constant of the scalar, rounded to it."""
        code = ">d" if self.scalar == "double" else ">f"
        bits = int.from_bytes(struct.pack(code, value), "big")
        return self.bits.value(bits)

    def add(self, a, b):
        return self.exact_sum(a, b) if self.exact else self.sums.sum(a, b)

    def exact_sum(self, a, b):
        """The sum of IEEE 754, whose bits are not the solver's own."""
        result = self.fresh("sum")
        x, y, z = (self.terms.mk_term(Kind.FP_TO_FP_FROM_BV, [v], [self.exponent, self.significand]) for v in (a, b, result))
        self.facts.append(self.of(Kind.EQUAL, self.of(Kind.FP_ADD, self.nearest, x, y), z))
        return result

    def sub(self, a, b):
        return self.add(a, self.of(Kind.FP_NEG, b))

    def signed(self, a, b):
        """A product or quotient: sign or not a number."""
        result = self.fresh("product")
        negative = self.of(Kind.XOR, self.of(Kind.FP_IS_NEG, a), self.of(Kind.FP_IS_NEG, b))
        same = self.of(Kind.EQUAL, self.of(Kind.FP_IS_NEG, result), negative)
        none = self.of(Kind.FP_IS_NAN, result)
        self.facts.append(self.of(Kind.OR, none, same))
        for operand in (a, b):
            self.facts.append(self.of(Kind.IMPLIES, self.of(Kind.FP_IS_NAN, operand), none))
        return result

    def compare(self, predicate, a, b):
        if predicate in NEGATED:
            return self.of(Kind.NOT, self.compare(NEGATED[predicate][0], a, b))
        if predicate in ("uno", "ord"):
            none = self.of(Kind.OR, self.of(Kind.FP_IS_NAN, a), self.of(Kind.FP_IS_NAN, b))
            return none if predicate == "uno" else self.of(Kind.NOT, none)
        if predicate == "one":
            return self.of(Kind.OR, self.of(Kind.FP_LT, a, b), self.of(Kind.FP_GT, a, b))
        return self.of(COMPARISONS[predicate.removeprefix("o")], a, b)

    def constant(self, text, kind):
        if kind == "i1":
            return {"true": self.terms.mk_true(), "false": self.terms.mk_false()}[text]
        if text.startswith("0x"):
            return self.number(struct.unpack(">d", bytes.fromhex(text[2:].rjust(16, "0")))[0])
        return self.number(float(text))

    # Running.
    def run(self, name, arguments, memory):
        """The result of a function; `memory` is changed, `facts` holds the facts about the unknown numbers."""
        parameters, body = self.module.functions[name]
        values = dict(zip(parameters, arguments, strict=True))
        reached, edges, results = {}, {}, []
        for label in order(body):
            into = [condition for (_, to), condition in edges.items() if to == label]
            reached[label] = self.any(into) if into else self.terms.mk_true()
            for line in body[label]:
                self.instruction(line, label, values, memory, (reached[label], edges, results))
        if not results or results[0][1] is None:
            return None
        value = results[-1][1]
        for condition, other in reversed(results[:-1]):
            value = self.of(Kind.ITE, condition, other, value)
        return value

    def any(self, conditions):
        return conditions[0] if len(conditions) == 1 else self.of(Kind.OR, *conditions)

    def instruction(self, line, label, values, memory, flow):
        reached, edges, results = flow
        value = lambda text, kind: values[text] if text in values else self.constant(text, kind)
        line = re.sub(r", (![\w.]+ !\d+|align \d+)", "", re.sub(r" #\d+.*$", "", line))
        target, _, right = line.rpartition(" = ") if re.match(rf"{NAME} = ", line) else ("", "", line)
        word, _, rest = right.partition(" ")
        if word == "br":
            return self.branch(rest, label, reached, edges, value)
        if word == "ret":
            kind, _, text = rest.partition(" ")
            results.append((reached, None if kind == "void" else value(text, kind)))
            return None
        if word == "store":
            kind, text, pointer = read(rf"(\w+) (\S+), ptr ({NAME})", rest)
            place = values[pointer]
            old = memory[place]
            memory[place] = self.of(Kind.ITE, reached, value(text, kind), old)
            return None
        if word in ("tail", "call", "notail"):
            result = self.call(right, value, values, memory, reached)
            if target:
                values[target] = result
            return None
        values[target] = self.operation(word, rest, value, values, memory, edges, label)
        return None

    def branch(self, rest, label, reached, edges, value):
        targets = [text.strip('%"') for text in re.findall(rf"label ({NAME})", rest)]
        if len(targets) == 1:
            edges[label, targets[0]] = reached
            return
        condition = value(re.match(r"i1 ([^,]+),", rest).group(1), "i1")
        edges[label, targets[0]] = self.of(Kind.AND, reached, condition)
        edges[label, targets[1]] = self.of(Kind.AND, reached, self.of(Kind.NOT, condition))

    def operation(self, word, rest, value, values, memory, edges, label):
        if word == "load":
            kind, pointer = read(rf"(\w+), ptr ({NAME})", rest)
            self.same_scalar(kind)
            return memory[values[pointer]]
        if word == "getelementptr":
            pointer, offset = read(rf"(?:inbounds |nuw |nusw )*i8, ptr ({NAME}), i(?:32|64) (\d+)", rest)
            base, byte = values[pointer]
            return base, byte + int(offset)
        if word in ("fadd", "fsub", "fmul", "fdiv"):
            # Flags of fast arithmetic are refused: they permit the compiler results other than those of IEEE 754.
            kind, a, b = read(r"(float|double) (\S+), (\S+)", rest)
            self.same_scalar(kind)
            make = {"fadd": self.add, "fsub": self.sub}.get(word, self.signed)
            return make(value(a, kind), value(b, kind))
        if word == "fneg":
            kind, a = read(r"(float|double) (\S+)", rest)
            return self.of(Kind.FP_NEG, value(a, kind))
        if word == "fcmp":
            predicate, kind, a, b = read(r"(\w+) (float|double) (\S+), (\S+)", rest)
            return self.compare(predicate, value(a, kind), value(b, kind))
        if word == "select":
            condition, kind, a, _, b = read(r"i1 (\S+), (\w+) (\S+), (\w+) (\S+)", rest)
            return self.of(Kind.ITE, value(condition, "i1"), value(a, kind), value(b, kind))
        if word in ("and", "or", "xor"):
            a, b = read(r"(?:disjoint )?i1 (\S+), (\S+)", rest)
            kind = {"and": Kind.AND, "or": Kind.OR, "xor": Kind.XOR}[word]
            return self.of(kind, value(a, "i1"), value(b, "i1"))
        if word == "phi":
            kind, _, pairs = rest.partition(" ")
            ways = re.findall(rf"\[ (\S+), ({NAME}) \]", pairs)
            ways = [(value(text, kind), edges[source.strip('%"'), label]) for text, source in ways]
            result = ways[-1][0]
            for way, condition in reversed(ways[:-1]):
                result = self.of(Kind.ITE, condition, way, result)
            return result
        if word == "sitofp":
            # Its integer is unknown; the number it gives is one.
            result = self.fresh("whole")
            self.facts.append(self.of(Kind.NOT, self.of(Kind.FP_IS_NAN, result)))
            return result
        # A Cortex-M passes the bits of a number to its square root as an integer, and has two integers back.
        if word == "bitcast":
            kind, a, to = read(r"(float|double|i32|i64) (\S+) to (float|double|i32|i64)", rest)
            return value(a, kind)
        if word == "extractvalue":
            a, part = read(rf"{{ i32, i32 }} ({NAME}), (\d+)", rest)
            if part == "0":
                return values[a]
        raise SystemExit(f"ir.py: found the instruction {word} {rest!r}, needed one that it knows")

    def call(self, text, value, values, memory, reached):
        if " asm " in text:
            # The processor's square root.
            if "sqrt" not in text:
                raise SystemExit(f"ir.py: found the assembly {text}, needed a square root")
            return self.fresh("root")
        name, arguments = re.search(r"@([-\w$.]+)\((.*)\)$", text).groups()
        if name.startswith(IGNORED):
            return None
        if name.startswith("llvm.fabs"):
            return self.of(Kind.FP_ABS, value(arguments.split()[-1], self.scalar))
        if name.startswith("llvm.fptosi.sat"):
            return Unknown()
        if "sqrt" in name:
            return self.fresh("root")
        passed = []
        for argument in re.split(r", (?=(?:ptr|float|double|i1) )", arguments):
            passed.append(value(argument.split()[-1], argument.split()[0]))
        inner = dict(memory)
        result = self.run(name, passed, inner)
        for place, term in inner.items():
            if term is not memory[place]:
                memory[place] = self.of(Kind.ITE, reached, term, memory[place])
        return result

    def same_scalar(self, kind):
        if kind != self.scalar:
            raise SystemExit(f"ir.py: found {kind}, needed {self.scalar}: the function mixes scalars")


def order(body):
    """Labels so that each comes after all from which it is reached; refuses loops."""
    following = {label: [t.strip('%"') for t in re.findall(rf"label ({NAME})", lines[-1])] for label, lines in body.items()}
    done, open_, found = set(), set(), []

    def visit(label):
        if label in open_:
            raise SystemExit(f"ir.py: found a loop through {label}, needed loop-free code")
        if label in done:
            return
        open_.add(label)
        for to in following[label]:
            visit(to)
        open_.discard(label)
        done.add(label)
        found.insert(0, label)

    visit(next(iter(body)))
    return found
