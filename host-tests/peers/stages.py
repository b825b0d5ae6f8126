#!/usr/bin/env python3
"""Says what the stages of `fast` take of a frame: usage, stages.py PERF_DATA [NANOSECONDS]

    cargo build --profile profiling -p slicecast-bench --example fast
    perf record -F 4000 -e cpu-clock -o fast.data target/profiling/examples/fast 1 avx512 256 60
    host-tests/peers/stages.py fast.data

Every address that `perf` has met is looked up with the functions that were inlined there (`addr2line -i`), and counts for the
first stage of the list below to which one of them belongs. Of what runs before the first frame (the volume is made, other
precisions' tables) and of other programs nothing counts. With a frame's nanoseconds a sample, which the example prints, shares become nanoseconds. Needs perf and
binutils. Not part of the build.
"""
import collections, re, subprocess, sys

# A file and functions in it. What sets rows up is left to lines further down, for it calls what the kernels are.
STAGES = [
    ("light", r"fast/light\.rs", r"."),
    ("compositing", r"fast/fold\.rs", r"."),
    ("table: fetch", r"fast/table\.rs", r"fetch"),
    ("table: mixture", r"fast/table\.rs", r"mix_row"),
    ("gradient", r"fast/sample\.rs", r"(mixed|slopes|slope|difference|halve|face|space)_row"),
    ("samples", r"fast/sample\.rs", r"(yx|z)_row"),
    ("gradient: rows set up, ends mended", r"plane/fast/source\.rs", r"gradients|mend|derivative|rise|space|slope"),
    ("samples: rows set up", r"plane/fast/source\.rs", r"."),
    ("what is visible, what is finished", r"plane/(fast/pixels|canvas)\.rs", r"."),
    ("voxels asked for from memory", r"engine/src/simd/mod\.rs", r"prefetch"),
    ("driver, planes and rows", r"core/src/(plane|plan|locate|view|slice|classify|fast|composite|lanes)", r"."),
]


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__.splitlines()[0], file=sys.stderr)
        return 2
    script = ["perf", "script", "-i", sys.argv[1], "-F", "ip,sym,symoff,dso", "--no-demangle"]
    text = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    met = collections.Counter()
    for line in text.splitlines():
        found = re.match(r"\s*[0-9a-f]+ (\S+)\+0x([0-9a-f]+) \((/\S+)\)", line)
        if found:
            met[found.group(3), found.group(1), int(found.group(2), 16)] += 1
    programs = collections.Counter()
    for (program, _, _), count in met.items():
        programs[program] += count
    if not programs:
        sys.exit(f"{sys.argv[1]}: no addresses in a program, expected those of a build with line tables")
    program = max(programs, key=lambda name: (name.endswith("/fast"), programs[name]))
    places = {}
    for line in subprocess.run(["nm", program], check=True, capture_output=True, text=True).stdout.splitlines():
        parts = line.split()
        if len(parts) == 3:
            places[parts[2]] = int(parts[0], 16)
    counts = {places[name] + offset: count for (where, name, offset), count in met.items() if where == program and name in places}
    given = "\n".join(hex(address) for address in counts) + "\n"
    command = ["addr2line", "-a", "-i", "-f", "-C", "-e", program]
    text = subprocess.run(command, input=given, check=True, capture_output=True, text=True).stdout
    shares, address, function, chain = collections.Counter(), None, None, []

    def close():
        if address is not None:
            shares[stage(chain)] += counts[address]

    for line in text.splitlines():
        if re.fullmatch(r"0x[0-9a-f]+", line):
            close()
            address, function, chain = int(line, 16), None, []
        elif function is None:
            function = line
        else:
            chain.append((function, line))
            function = None
    close()
    shares.pop(None, None)
    whole = sum(shares.values())
    nanoseconds = float(sys.argv[2]) if len(sys.argv) == 3 else None
    print("| stage | share |" + (" ns a sample |" if nanoseconds else ""))
    print("|---|---|" + ("---|" if nanoseconds else ""))
    for name, count in shares.most_common():
        print(f"| {name} | {100 * count / whole:.1f} % |" + (f" {nanoseconds * count / whole:.3f} |" if nanoseconds else ""))
    print(f"\n{whole} samples of {program}")


def stage(chain):
    """The first in the list that has one of the functions."""
    for name, file, function in STAGES:
        for called, line in chain:
            if re.search(file, line) and re.search(function, called):
                return name
    return None


if __name__ == "__main__":
    sys.exit(main())
