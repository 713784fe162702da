#!/usr/bin/env python3
"""Bound of the instructions of a function in a linked Cortex-M program: the longest path through its control flow.

    longest_path.py ELF FUNCTION [--processor cortex-m4] [--json] [--loops] [--without PART]... [--let NAME=NUMBER]...
                    [--seen NUMBER] [--most RATIO] [--trace FILE]...

The program is disassembled and split into blocks; a call costs the longest path through its callee. Instructions are counted as
QEMU counts them, including those that a condition skips. Code without a bound is an error that names its place: a call or a jump
through a register, a recursion, a loop with two entries, a loop whose rounds are not stated.

Comments in the source state what the code does not show. Each is on the line that it describes, or directly above it:

    // At most N rounds.                          on a loop: its block begins at most N times whenever the loop is reached. N is a
                                                  number, a constant of the same file or a --let. A loop in an expression
                                                  (iterators, from_fn) takes that of its statement. Unrolled and rotated loops
                                                  are bounded by it too.
    // At most N rounds without PART, else M.     N if the part is left out
    // Only with PART.                            on a function, an impl, an arm or a block: never runs in a machine without this
                                                  part; --without leaves it out
    // Takes K of at most N NAMES in one step.    on a function: all calls of the functions with this word together take no more
    // Never both A and B in one step.            anywhere in a file: no step runs code of both parts

A reason may follow each. Comments are looked for only in files whose code is on some path. Line numbers come from the program:
a source that is newer than the program is refused.

A part that is left out is one that the machine lacks. Its blocks are dropped, those all of whose lines are in its code, and
with them what only they lead to. Of two parts that never meet, the longer of both bounds counts. A stated number of takes is
used by Lagrangian relaxation: with any price on each take, the longest path with prices plus price times number is a bound; the
prices are searched for the least.

Functions of the compiler that copy and clear constant numbers of bytes are run (memory_calls.py). A call that does not
return, a panic, ends a path.

--seen: instructions of the worst run known, below which a bound is wrong (exit 1); --most: exit 1 where the bound is above
this multiple of it. --trace: a file of executed.c, whose first call of the function must be a path of this graph, without parts
that never meet, with no more rounds and takes than stated, and not longer than the bound.
"""

import argparse
import json
import re
import sys
from collections import Counter, defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import memory_calls  # noqa: E402
from stated import Frames, Sources  # noqa: E402
from thumb import RETURN, Program, Refused  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
# Calls that do not return.
PANIC = re.compile(r"^core::.*(panic|_failed$|_fail$)")
# Rounds of loops in code without a source here, by function.
LIBRARY = {
    # Long division of 64 bits by 32 or 64: at most 32 bits of the quotient one by one, four in a round.
    "compiler_builtins::int::specialized_div_rem::u64_div_rem": 8,
}
# Sweeps over the prices.
SWEEPS = 4


# Instructions of calls that are run instead of searched.
FIXED = "copied or cleared"


class Edge:
    """A way from one node to the next: its instructions, and the blocks that it runs with their numbers of times."""

    __slots__ = ("weight", "parts")

    def __init__(self, weight, parts):
        self.weight, self.parts = weight, parts

    def count(self, into, times=1):
        for number, part in self.parts:
            if isinstance(part, Edge):
                part.count(into, times * number)
            else:
                into[part] += times * number


def joined(edges):
    return Edge(sum(edge.weight for edge in edges), [(1, edge) for edge in edges])


def order(edges, start, inside=None):
    """Nodes in the order of a depth-first search from the start, each after all that lead to it but for loops."""
    done, seen, stack = [], {start}, [(start, iter(edges.get(start, ())))]
    while stack:
        node, rest = stack[-1]
        for target in rest:
            if target not in seen and (inside is None or target in inside):
                seen.add(target)
                stack.append((target, iter(edges.get(target, ()))))
                break
        else:
            done.append(node)
            stack.pop()
    return done[::-1]


def dominators(before, nodes):
    """Immediate dominator of every node, from the nodes before each; nodes in the order of `order`."""
    place = {node: k for k, node in enumerate(nodes)}
    found = {nodes[0]: nodes[0]}
    changed = True
    while changed:
        changed = False
        for node in nodes[1:]:
            new = None
            for other in (b for b in before[node] if b in found):
                if new is None:
                    new = other
                while new != other:
                    if place[new] > place[other]:
                        new = found[new]
                    else:
                        other = found[other]
            if found.get(node) != new:
                found[node], changed = new, True
    return found


def loops(edges, nodes, name):
    """Header to nodes of every natural loop, the innermost first."""
    before, found = defaultdict(list), {}
    for node in nodes:
        for target in edges.get(node, ()):
            before[target].append(node)
    above, place = dominators(before, nodes), {node: k for k, node in enumerate(nodes)}
    for node in nodes:
        for target in edges.get(node, ()):
            if place.get(target, len(nodes)) > place[node]:
                continue
            at = node
            while at != target and at != above[at]:
                at = above[at]
            if at != target:
                raise Refused(f"{name}: found a loop with two entries at {target:#x}, which has no bound here")
            inside, todo = found.setdefault(target, {target}), [node]
            while todo:
                if (at := todo.pop()) not in inside:
                    inside.add(at)
                    todo += before[at]
    return dict(sorted(found.items(), key=lambda item: len(item[1])))


def longest(edges, start, inside=None):
    """Longest way from the start to every node without going round: its edges by node."""
    best = {start: (0, None, None)}
    for node in order(edges, start, inside):
        if node not in best:
            continue
        for target, edge in edges.get(node, {}).items():
            if inside is not None and target not in inside or target == start:
                continue
            if target not in best or best[node][0] + edge.weight > best[target][0]:
                best[target] = (best[node][0] + edge.weight, node, edge)
    return best


def way(best, node):
    """The edges of a longest way to a node."""
    edges = []
    while best[node][1] is not None:
        edges.append(best[node][2])
        node = best[node][1]
    return edges[::-1]


def collapse(edges, header, inside, rounds):
    """Replaces a loop by its header, whose edges are the longest ways through all rounds and out."""
    best = longest(edges, header, inside)
    back = max(
        (joined([*way(best, node), edges[node][header]]) for node in inside if node in best and header in edges.get(node, ())),
        key=lambda edge: edge.weight,
    )
    turn = max(0, back.weight)
    out = {}
    for node in inside & best.keys():
        for target, edge in edges.get(node, {}).items():
            if target in inside:
                continue
            last = joined([*way(best, node), edge])
            # Out of the last round at the bottom, or out of the middle of a further one, which only tests.
            again = rounds - 1 if header in edges[node] else rounds
            whole = Edge(again * turn + last.weight, [(again if turn else 0, back), (1, last)])
            if target not in out or whole.weight > out[target].weight:
                out[target] = whole
    for node in inside:
        edges.pop(node, None)
    edges[header] = out


class Plan:
    """A function's blocks that can run, without prices: instructions, calls, where they go; its loops and their rounds."""

    def __init__(self, function):
        self.function, self.blocks, self.loops, self.takes = function, {}, [], None


class Paths:
    """Longest paths of the functions of a program without some parts."""

    def __init__(self, program, sources, without, known):
        self.program, self.sources, self.without, self.frames = program, sources, frozenset(without), known
        self.plans, self.missing, self.limits = {}, {}, {}
        self._above = []

    def plan(self, function):
        """Plan of a function, made after the plans of its callees; None if no path through it returns."""
        if function.address in self.plans:
            return self.plans[function.address]
        if function in self._above:
            raise Refused(f"{function.name} calls itself: no bound")
        self._above.append(function)
        plan, blocks = Plan(function), self.program.graph(function)
        todo = [function.address]
        while todo:
            if (at := todo.pop()) in plan.blocks or self.is_left_out(blocks[at]):
                continue
            block = blocks[at]
            calls = [(self.called(function, block, place, callee), skips) for place, callee, skips in block.calls]
            if (None, False) in calls:
                continue
            goes = {}
            for target in block.goes:
                if target == RETURN or target in blocks:
                    goes[target] = None
                    todo += [target] if target in blocks else []
                elif (tail := self.called(function, block, None, target)) is not None:
                    goes[target if tail else RETURN] = tail or None
            plan.blocks[at] = (len(block.instructions), calls, goes)
        self._above.pop()
        self._prune(plan)
        found = self.plans[function.address] = plan if function.address in plan.blocks else None
        if found:
            self._bound(found)
        return found

    @staticmethod
    def _prune(plan):
        """Drops the blocks that lead to no end."""
        before = defaultdict(list)
        for at, (_, _, goes) in plan.blocks.items():
            for target, tail in goes.items():
                before[RETURN if tail else target].append(at)
        good, todo = set(), [RETURN]
        while todo:
            new = set(before[todo.pop()]) - good
            good |= new
            todo += new
        for at in plan.blocks.keys() - good:
            del plan.blocks[at]
        for _, _, goes in plan.blocks.values():
            for target in [t for t, tail in goes.items() if not tail and t != RETURN and t not in good]:
                del goes[target]

    def is_left_out(self, block):
        """Whether all of a block is code of a part that is left out."""
        stacks = [stack for i in block.instructions if (stack := self.frames.at(i.address)) and stack[-1].line]
        return bool(stacks) and all(self.sources.only(stack) & self.without for stack in stacks)

    def called(self, function, block, place, address):
        """What a call executes: a plan, a number of instructions, or None if no path makes the call."""
        callee = self.program.functions.get(address)
        if callee is None:
            raise Refused(f"{function.name}: found a call of {address:#x}, where no function begins")
        if PANIC.search(callee.name):
            return 0
        if place is not None and callee.name in memory_calls.LENGTH:
            count = memory_calls.length_at(callee, block, place)
            if count is not None:
                return memory_calls.instructions_of(self.program, callee, count)
        return self.plan(callee)

    def _bound(self, plan):
        """Finds the loops of a plan, their rounds, and what a call takes."""
        function, blocks = plan.function, self.program.graph(plan.function)
        edges = {at: [RETURN if tail else target for target, tail in goes.items()] for at, (_, _, goes) in plan.blocks.items()}
        headers = loops(edges, order(edges, function.address), function.name)
        places = {}
        for header, inside in headers.items():
            places[header] = self.sources.place([self.frames.at(i.address) for at in inside for i in blocks[at].instructions])
        for header, inside in headers.items():
            within = [places[other] for other, larger in headers.items() if other != header and header in larger]
            rounds = self.rounds(function, header, places[header], [place for place in within if place])
            plan.loops.append((header, inside, rounds, places[header].text if places[header] else function.name))
        plan.takes = self.sources.takes(self.frames.at(function.address))
        if plan.takes:
            number, most, name = plan.takes
            if self.limits.setdefault(name, most) != most:
                raise Refused(f"{function.name}: found at most {most} {name} in one step, and {self.limits[name]} elsewhere")
            if function.address in headers:
                plan.takes = None

    def rounds(self, function, header, place, within):
        """Rounds of a loop at a place, inside loops at others."""
        here = f"{function.name} at {header:#x}"
        if place is None:
            if function.name not in LIBRARY:
                self.missing.setdefault(function.name, []).append(here)
            return LIBRARY.get(function.name, 1)
        if place.is_loop and any(place.at == other.at for other in within):
            raise Refused(f"{place.text}: found two loops in each other that are one in the source ({here})")
        # An outer loop of the source without a loop of its own in the program: either it was unrolled, or this is it and the
        # inner one was unrolled. Both bounds are needed.
        hidden = [at for at in place.outer if all(at != other.at for other in within)]
        found = []
        for path, line in [place.at, *hidden]:
            found.append(self.sources.rounds((path, line), self.without))
            if found[-1] is None:
                self.missing.setdefault(f"{path}:{line}", []).append(here)
        return max((one for one in found if one), default=1)

    def solved(self, function, prices):
        """The longest path with a price for every take."""
        known = {}
        for plan in filter(None, self.plans.values()):
            edges = {at: self._edges(plan, at, known, prices) for at in plan.blocks}
            for header, inside, rounds, _ in plan.loops:
                collapse(edges, header, inside, rounds)
            start = plan.function.address
            known[plan] = joined(way(longest(edges, start), RETURN))
        return known[self.plans[function.address]]

    @staticmethod
    def _edges(plan, at, known, prices):
        """Edges of a block, calls included."""
        weight, calls, goes = plan.blocks[at]
        parts = [(1, at)]
        if plan.takes and at == plan.function.address:
            weight -= plan.takes[0] * prices.get(plan.takes[2], 0)
        for call, skips in calls:
            edge = Edge(call, [(call, FIXED)]) if isinstance(call, int) else known.get(call)
            # A condition may skip the call.
            if edge and (edge.weight > 0 or not skips):
                parts.append((1, edge))
                weight += edge.weight
        out = {}
        for target, tail in goes.items():
            if tail:
                edge = Edge(tail, [(tail, FIXED)]) if isinstance(tail, int) else known[tail]
                edge = Edge(weight + edge.weight, [*parts, (1, edge)])
                if RETURN not in out or edge.weight > out[RETURN].weight:
                    out[RETURN] = edge
            elif target != RETURN or RETURN not in out or weight > out[RETURN].weight:
                out[target] = Edge(weight, parts)
        return out

    def taken(self, edge):
        """What a path takes, by name."""
        times, found = Counter(), Counter()
        edge.count(times)
        for plan in filter(None, self.plans.values()):
            if plan.takes:
                found[plan.takes[2]] += plan.takes[0] * times[plan.function.address]
        return found

    def least(self, function):
        """The least bound that prices give, and the path of it.

        The bound is convex in every price, and falls as long as the path takes more than is stated: that is bisected, one
        price after the other, until no price lowers it further.
        """
        prices, best = dict.fromkeys(self.limits, 0), None

        def bound():
            edge = self.solved(function, prices)
            return edge.weight + sum(prices[name] * most for name, most in self.limits.items()), edge

        best = bound()
        for _ in range(SWEEPS if prices else 0):
            before = best[0]
            for name, most in self.limits.items():
                low, high, kept = -1, best[0], prices[name]
                while high - low > 1:
                    prices[name] = (low + high) // 2
                    found = bound()
                    if found[0] < best[0]:
                        best, kept = found, prices[name]
                    if self.taken(found[1])[name] > most:
                        low = prices[name]
                    else:
                        high = prices[name]
                prices[name] = kept
            if best[0] == before:
                break
        return best


class Trace:
    """Follows the instructions that ran, along the graph."""

    def __init__(self, paths, function):
        self.paths, self.program, self.function = paths, paths.program, function
        self.most, self.takes, self.count = {}, Counter(), 0
        # Of every call that has not returned: plan, or None in a function that is run; where it goes on; rounds of its loops.
        self.stack = []

    def wrong(self, at, why):
        raise Refused(f"the trace leaves the graph at {at:#x} in {self.program.holding(at).name}: {why}")

    def enter(self, at, back, caller):
        """A call or a tail call of a function that begins here, from one with this plan."""
        function = self.program.functions.get(at)
        if function is None:
            self.wrong(at, "no function begins here")
        plan = self.paths.plans.get(at)
        if plan is None and caller and function.name not in memory_calls.LENGTH:
            self.wrong(at, "the function was left out")
        if plan and plan.takes:
            self.takes[plan.takes[2]] += plan.takes[0]
        self.stack.append((plan, back, {}))

    def block(self, at, before):
        """A block begins."""
        plan, _, rounds = self.stack[-1]
        if plan is None:
            return
        if at not in plan.blocks:
            self.wrong(at, "the block was left out")
        for header, inside, most, where in plan.loops:
            if header == at:
                rounds[at] = rounds[at] + 1 if before in inside else 1
                self.most[where] = max(self.most.get(where, (0, most)), (rounds[at], most))
                # A loop whose test comes first begins once more.
                if rounds[at] > most + 1:
                    self.wrong(at, f"{where} has more than {most} rounds")

    def follow(self, addresses):
        """Follows the first call of the function; returns its number of instructions."""
        calls = {}
        blocks = {}
        self.enter(self.function.address, None, self.paths.plans[self.function.address])
        now = None
        for number, at in enumerate(addresses):
            self.count = number
            if not self.stack:
                return number
            function = self.program.holding(at)
            here = self.program.graph(function)
            if function.address not in blocks:
                blocks[function.address] = {i.address: b for b in here.values() for i in b.instructions}
                calls |= {place: (callee, skips) for b in here.values() for place, callee, skips in b.calls}
            block = blocks[function.address].get(at)
            if block is None:
                self.wrong(at, "no instruction of a block")
            if at == block.address:
                self.block(at, now)
                now = at
            last = block.instructions[-1].address == at
            following = at + function.instructions[at].length
            if number + 1 == len(addresses):
                break
            after = addresses[number + 1]
            callee, skips = calls.get(at, (None, False))
            if callee is not None and not (skips and after != callee):
                if after != callee:
                    self.wrong(at, f"a call goes to {after:#x}")
                self.enter(after, (following, now), self.stack[-1][0])
                now = None
            elif last and after in block.goes:
                if after not in here:
                    caller, back, _ = self.stack.pop()
                    self.enter(after, back, caller)
                    now = None
            elif last and RETURN in block.goes:
                back = self.stack.pop()[1]
                if back is not None:
                    if after != back[0]:
                        self.wrong(at, f"a return goes to {after:#x}")
                    now = back[1]
            elif last or after != following:
                self.wrong(at, f"an instruction goes to {after:#x}")
        raise Refused("the trace does not return from the function")


def sought(program, sources, function, without):
    """Bound, path and paths of every choice among parts that never meet, the largest bound first."""
    known = Frames(program.elf.path, sources)
    found, todo = [], [frozenset(without)]
    while todo:
        chosen = todo.pop()
        paths = Paths(program, sources, chosen, known)
        if paths.plan(function) is None:
            raise Refused(f"{function.name}: found no path to an end")
        if paths.missing:
            lines = [f"{where}: found a loop without a bound ({'; '.join(at)})" for where, at in sorted(paths.missing.items())]
            raise Refused("needed `// At most N rounds.` for\n" + "\n".join(lines))
        met = next((pair for pair in sources.never_both() if not set(pair) & chosen), None)
        if met:
            todo += [chosen | {one} for one in met]
            continue
        found.append((*paths.least(function), paths))
    return sorted(found, key=lambda one: -one[0])


def followed(file, function, choices):
    """Follows a trace along the graph of one of the choices."""
    addresses = [int(line, 16) for line in Path(file).read_text().split()]
    for bound, _, paths in choices:
        trace = Trace(paths, function)
        try:
            count = trace.follow(addresses)
        except Refused as error:
            wrong = error
            continue
        over = {name: n for name, n in trace.takes.items() if n > paths.limits[name]}
        if over:
            raise Refused(f"{file}: found {over} taken, needed at most {paths.limits}")
        if count > bound:
            raise Refused(f"{file}: found {count} instructions, above the bound {bound}")
        return {"file": file, "instructions": count, "takes": trace.takes, "rounds": trace.most}
    raise Refused(f"{file}: {wrong}")


def report(best):
    """What the bound is made of."""
    bound, edge, paths = best
    times, instructions, lines = Counter(), Counter(), Counter()
    edge.count(times)
    for at, number in times.items():
        if at == FIXED:
            instructions[FIXED] += number
            continue
        function = paths.program.holding(at)
        for i in function.blocks[at].instructions:
            instructions[function.name] += number
            own = [frame for frame in paths.frames.at(i.address) if frame.path]
            lines[f"{own[-1].path}:{paths.sources.file(own[-1].path).function_line(own[-1].line)}" if own else "?"] += number
    callers = Counter()
    for at, number in times.items():
        for _, callee, _ in paths.program.holding(at).blocks[at].calls if at != FIXED else ():
            callers[paths.program.holding(at).name, paths.program.functions[callee].name] += number
    calls = {paths.program.holding(at).name: n for at, n in times.items() if at in paths.program.functions}
    plans = filter(None, paths.plans.values())
    rounds = [(where, n, header, plan.function.name) for plan in plans for header, _, n, where in plan.loops]
    return {
        "bound": bound,
        "path": sum(instructions.values()),
        "left_out": sorted(paths.without),
        "limits": paths.limits,
        "functions": [{"function": n, "calls": calls.get(n), "instructions": k} for n, k in instructions.most_common()],
        "source": [{"function": n, "instructions": k} for n, k in lines.most_common()],
        "calls": [{"from": a, "to": b, "times": n} for (a, b), n in callers.most_common()],
        "loops": [{"at": w, "rounds": n, "address": hex(h), "function": f} for w, n, h, f in sorted(rounds)],
    }


def show(found, options):
    print(f"{found['bound']} instructions at most; the path found has {found['path']}")
    for name, most in found["limits"].items():
        print(f"at most {most} {name}")
    print(f"{'instructions':>12} {'share':>6} {'calls':>6}")
    for one in found["functions"]:
        share = 100 * one["instructions"] / found["path"]
        print(f"{one['instructions']:12} {share:5.1f}% {one['calls'] or '-':>6}  {one['function']}")
    if options.lines:
        for one in found["source"]:
            print(f"{one['instructions']:12}  {one['function']}")
    if options.calls:
        for one in found["calls"]:
            print(f"{one['times']:5} calls  {one['to']}  from {one['from']}")
    if options.loops:
        for one in found["loops"]:
            print(f"{one['rounds']:5} rounds  {one['at']}  {one['address']} in {one['function']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("elf")
    parser.add_argument("function")
    parser.add_argument("--processor", default="cortex-m4")
    parser.add_argument("--root", default=str(ROOT), help="folder of the sources")
    parser.add_argument("--without", action="append", default=[], metavar="PART")
    parser.add_argument("--let", action="append", default=[], metavar="NAME=NUMBER")
    parser.add_argument("--seen", type=int)
    parser.add_argument("--most", type=float)
    parser.add_argument("--trace", action="append", default=[], metavar="FILE")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--lines", action="store_true", help="also by functions of the source, inlined ones apart")
    parser.add_argument("--calls", action="store_true", help="also the calls of the path")
    parser.add_argument("--loops", action="store_true", help="also the rounds of all loops")
    options = parser.parse_args()
    given = {name: int(number) for name, number in (one.split("=") for one in options.let)}
    program = Program(options.elf, options.processor)
    sources = Sources(options.root, given, Path(options.elf).stat().st_mtime)
    function = program.named(options.function)
    choices = sought(program, sources, function, options.without)
    found = report(choices[0])
    found["traces"] = [followed(file, function, choices) for file in options.trace]
    print(json.dumps(found, indent=1)) if options.json else show(found, options)
    for trace in found["traces"] if not options.json else ():
        print(f"{trace['file']}: a path of this graph, {trace['instructions']} instructions")
    if options.seen is not None:
        ratio = found["bound"] / options.seen
        if not options.json:
            print(f"worst seen {options.seen}; the bound is {ratio:.3f} of it")
        if ratio < 1 or options.most is not None and ratio > options.most:
            raise Refused(f"found a bound of {ratio:.3f} of the worst seen, needed 1 to {options.most}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Refused as error:
        sys.exit(f"longest_path.py: {error}")
