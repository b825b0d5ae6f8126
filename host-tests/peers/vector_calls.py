#!/usr/bin/env python3
"""Finds vectors that are handed over by calls, which is ten times slower than in registers: usage, vector_calls.py PROGRAM

Every function that the code of a vector width calls has to be inlined into it (`slicecast_sim::simd::with_lanes`). The compiler
inlines a function because it is told to, but a closure, or the one given to an array's `map`, only when it likes to; and what it
likes changes with the program around. This reads a release build (objdump) and names each function with vector instructions that
such code calls. Nothing to name: 0, else 1.
"""

import collections
import re
import subprocess
import sys

ENTRIES = ("with_lanes", "with_floats", "::entry")


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__.splitlines()[0], file=sys.stderr)
        return 2
    dump = subprocess.Popen(
        ["objdump", "-d", "-C", "--no-show-raw-insn", "-M", "intel", sys.argv[1]],
        stdout=subprocess.PIPE,
        text=True,
    )
    names, vectors, calls, address = {}, collections.Counter(), collections.Counter(), None
    assert dump.stdout is not None
    for line in dump.stdout:
        if heading := re.match(r"0*([0-9a-f]+) <(.*)>:$", line):
            address = heading[1]
            names[address] = heading[2]
        elif address is not None:
            vectors[address] += bool(re.search(r"\b[yz]mm\d", line))
            called = re.search(r"\bcall\s+([0-9a-f]+) <", line)
            if called and any(entry in names[address] for entry in ENTRIES):
                calls[called[1]] += 1
    if dump.wait() != 0:
        print(f"{sys.argv[1]}: objdump cannot read it", file=sys.stderr)
        return 2
    if not any(any(entry in name for entry in ENTRIES) for name in names.values()):
        print(f"{sys.argv[1]}: no code over lanes in it, or no names of functions", file=sys.stderr)
        return 2
    found = [(calls[address], vectors[address], names[address]) for address in calls if vectors[address]]
    for sites, count, name in sorted(found, reverse=True):
        print(f"{name}: called at {sites} places, {count} vector instructions")
    print(f"{len(calls)} functions are called by code over lanes, {len(found)} of them with vectors")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
