#!/usr/bin/env python3
"""Finds vector code that was not inlined into a vector width's: usage, vector_calls.py PROGRAM

All that the code of a width calls is to be inlined into it (`slicecast_engine::simd::entry`). The compiler inlines a function
because it is told to, but a closure, or what is given to an array's `map` or an iterator's `all`, only when it likes to; and
what it likes changes with the program around. What is left outside is compiled without the processor's vectors, hands them
over through memory and calls a function for each instruction: a frame took three times as long. This reads a release build
(objdump) and names the functions that call such functions. None: 0, else 1.
"""

import collections
import re
import subprocess
import sys

ENTRY = "simd::entry::"
INSTRUCTION = re.compile(r"core::core_arch::x86::(avx|bmi|fma)\w*::(\w+)")


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__.splitlines()[0], file=sys.stderr)
        return 2
    dump = subprocess.Popen(
        ["objdump", "-d", "-C", "--no-show-raw-insn", "-M", "intel", sys.argv[1]],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert dump.stdout is not None
    callers, caller, entries = collections.defaultdict(set), "", 0
    for line in dump.stdout:
        if heading := re.match(r"[0-9a-f]+ <(.*)>:$", line):
            caller = heading[1]
            entries += ENTRY in caller
        elif " call " in line or "\tcall " in line or " jmp " in line:
            if called := INSTRUCTION.search(line):
                callers[caller].add(called[2])
    if dump.wait() != 0 or entries == 0:
        print(f"{sys.argv[1]}: no code over lanes found in it", file=sys.stderr)
        return 2
    for name, called in sorted(callers.items()):
        print(f"{name} calls {', '.join(sorted(called))}")
    print(f"{len(callers)} functions hold vector code outside that of a width")
    return 1 if callers else 0


if __name__ == "__main__":
    sys.exit(main())
