"""A great study, cold and again and again warm, under a limit on memory: does anything grow, does any byte change?

    make soak                            ten minutes of operations, then this; writes docs/reliability.md
    python3 benches/great.py --help

Each run may have so many megabytes of data (`prlimit --data`) and no more. After each the store is measured, and its results are
held against those after the first run. "From the store" are warm runs: as they come, without the results for people (which are
made anew from the store), and without the index (which comes back).
"""
import os, shutil, subprocess, sys, tempfile, time
from pathlib import Path

from common import Study, arguments, machine, sweep, table, write_section


class Great(Study):
    def measured(self, limit):
        """One run: how long, its peak of memory, what it said; then the store."""
        start = time.monotonic()
        command = ["prlimit", f"--data={limit}000000", *self.command()]
        child = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True)
        said = child.stderr.read()
        _, status, used = os.wait4(child.pid, 0)
        seconds = time.monotonic() - start
        if status != 0:
            sys.exit(f"a run ended with {status}:\n{said[-2000:]}")
        files = [p for p in self.store.rglob("*") if p.is_file()]
        size = sum(p.stat().st_size for p in files)
        return said.splitlines()[-1], seconds, used.ru_maxrss / 1024, len(files), size / 1e6


def main():
    parser = arguments(__doc__)
    parser.add_argument("--nodes", type=int, default=10_000)
    parser.add_argument("--limit", type=int, default=150, help="of memory [MB]")
    parser.add_argument("--warm", type=int, default=6, help="warm runs")
    args = parser.parse_args()
    work = Path(tempfile.mkdtemp(prefix="hvi-great-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    try:
        study = Great(args.program, work, sweep(f'"1.2 .. 1.6 in {args.nodes}"'))
        rows, right, steady = [], None, True
        for turn in range(args.warm + 1):
            what = "cold"
            if turn:
                what = ["warm", "warm, without out/", "warm, without the index"][(turn - 1) % 3]
            if "without" in what:
                shutil.rmtree(work / "out")
            if "index" in what:
                (study.store / "index").unlink()
            said, seconds, peak, files, size = study.measured(args.limit)
            right = right or study.objects()
            computed = said.split(" from the store, ")[1].split(" ")[0]
            same = study.objects() == right and len(right) == args.nodes
            steady &= same and computed == (str(args.nodes) if turn == 0 else "0")
            rows.append([what, computed, f"{seconds:.1f}", f"{peak:.0f}", files, f"{size:.1f}", "yes" if same else "NO"])
    finally:
        shutil.rmtree(work, ignore_errors=True)
    head = ["run", "computed", "s", "most memory, MB", "files in the store", "their MB", "same results"]
    text = table(head, rows) + f"\n\n{args.nodes} nodes, {args.limit} MB of data at most. {machine()}\n"
    print(text)
    if args.write:
        about = __doc__.split("--help\n\n")[1].strip()
        write_section(args.write, "What faults do", "A great study", f"Made by `make soak` (`benches/great.py`).\n\n{about}\n\n{text}")
    sys.exit(0 if steady else 1)


if __name__ == "__main__":
    main()
