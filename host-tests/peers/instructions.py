"""Counts the instructions that the row kernels execute for 16 samples, by stepping through them in gdb.

    cargo bench -p slicecast-host-tests --no-run      # prints where the benches are
    python3 host-tests/peers/instructions.py target/release/deps/stages-... [--precision compact]

A time says how fast a kernel ran beside whatever else ran; the instructions say how fast it could run at best. Vector
instructions other than moves need one of the units that calculate: with w of them for 16 samples, a processor that
starts u a cycle takes at least w / u cycles. (Zen 4 starts two of 512 bits or four of 256, and six instructions of any
kind.) Kernels are those of `cargo bench ... row-256`, on their random rows: every vector is lit, and nearly every one has
a highlight. Normalisation includes the copying of its input. Needs gdb and nm; a minute a width. Not part of the build.
"""
import argparse, collections, re, subprocess, sys

# How often a frame of one colour calls each, one plane per voxel: lit, unlit.
KERNELS = {
    "interpolate-yx": (2, 0),  # samples, and derivatives along z
    "interpolate-z": (2, 0),  # likewise
    "interpolate-in-slice": (0, 1),
    "gradient-difference": (2, 0),  # along x and along y
    "normalise": (1, 0),
    "shade": (1, 0),
    "opacity-linear-16": (1, 1),
    "colour-linear-16": (0, 0),
    "composite": (1, 0),
    "composite-one-colour": (0, 1),
}
# Calls of a kernel before the width's code is left, and runs of 16 in its row of 256: `stages.rs`.
SIXTEENS = 16 * (256 // 16)


def step():
    """Runs inside gdb: one call of the width's code, instruction by instruction."""
    import gdb

    gdb.execute("set pagination off")
    gdb.execute("starti", to_string=True)
    program = gdb.current_progspace().filename
    maps = gdb.execute("info proc mappings", to_string=True)
    base = min(int(line.split()[0], 16) for line in maps.splitlines() if line.endswith(program))
    for line in subprocess.run(["nm", program], capture_output=True, text=True).stdout.splitlines():
        if "with_lanes5entry" in line:
            gdb.Breakpoint(f"*{base + int(line.split()[0], 16):#x}")
    gdb.execute("continue", to_string=True)
    frame = gdb.newest_frame()
    arch, stack = frame.architecture(), int(frame.read_register("rsp"))
    count, known = collections.Counter(), {}
    while True:
        pc = gdb.newest_frame().pc()
        if pc not in known:
            text = arch.disassemble(pc)[0]["asm"]
            name = text.split()[0]
            vector = re.search(r"%[xyz]mm", text) and not name.startswith(("vmov", "mov"))
            known[pc] = ("vector" if vector else "other", name.startswith("ret"))
        kind, leaves = known[pc]
        count[kind] += 1
        if leaves and int(gdb.newest_frame().read_register("rsp")) >= stack:
            break
        gdb.execute("stepi", to_string=True)
    print("COUNT", count["vector"], count["vector"] + count["other"])
    gdb.execute("kill")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench")
    parser.add_argument("--precision", default="compact")
    options = parser.parse_args()
    for width, per_cycle in (("avx512", 2), ("avx2", 4)):
        print(f"{options.precision}, {width}: for 16 samples")
        print(f"  {'kernel':22}{'vector':>8}{'all':>8}{'cycles at least':>18}")
        lit = unlit = 0.0
        for kernel, (when_lit, when_unlit) in KERNELS.items():
            name = f"row-256/{kernel}/{options.precision}/{width}"
            command = ["gdb", "-q", "-batch", "-x", __file__, "--args", options.bench, "--bench", "--profile-time", "1", name]
            out = subprocess.run(command, capture_output=True, text=True).stdout
            found = re.search(r"COUNT (\d+) (\d+)", out)
            if not found:
                sys.exit(f"{name}: gdb reached no kernel; it said:\n{out[-2000:]}")
            vector, every = (int(n) / SIXTEENS for n in found.groups())
            cycles = max(vector / per_cycle, every / 6)
            print(f"  {kernel:22}{vector:8.1f}{every:8.1f}{cycles:18.1f}")
            lit += when_lit * cycles
            unlit += when_unlit * cycles
        print(f"  a frame of one colour: lit {lit:.0f} cycles at least, unlit {unlit:.0f}\n")


if "gdb" in sys.modules or __name__ == "__main__":
    try:
        import gdb  # noqa: F401
        step()
    except ImportError:
        main()
