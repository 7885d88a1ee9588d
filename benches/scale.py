"""The same studies on this machine and as jobs of a real Slurm cluster of one node: the same digests?

    make scale                           builds hvi-flow, starts a private cluster, writes docs/scale.md; some five minutes
    python3 benches/scale.py --help

The cluster is that of the tests (`tests/slurm.sh`): slurmctld, slurmd and munged on the loopback. It has two job slots a
core, so times say what Slurm costs, not what a cluster gains.
"""
import argparse, json, os, shutil, signal, subprocess, sys, tempfile, time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "tests/slurm.sh"
SHORT = """
[step.metal]
use = "eos.handbook"
mie_gruneisen = { density = "8930 kg/m3", sound_speed = "3940 m/s", slope = 1.5, gruneisen = 2.02, heat_capacity = "385 J/kg/K" }
sweep = { "mie_gruneisen.slope" = "1.2 .. 1.6 in COUNT" }
"""
IMPACTS = """
[step.set]
use = "eos.handbook"
set = "copper-royce"
[step.hit]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper", eos = "@set" }
plate = { material = "copper", thickness = "0.5 mm", width = "3 mm", eos = "@set" }
cells = CELLS
end = "3 us"
sweep = { velocity = [VELOCITIES] }
[step.film]
use = "radiograph"
run = "@hit[velocity=2 km/s]"
width = 64
"""


HEAD = """# Studies on a cluster

    hvi-flow run study.toml --executor slurm    submits what isn't in the store, and waits; Ctrl-C leaves the jobs, the same
                                                command returns to them
    hvi-flow cancel study.toml                  ends them

Or in the pipeline; nothing of it enters a key:

```toml
[run]
executor = "slurm"
[run.slurm]
partition = "compute"   # also: account, qos, constraint
time = "12 h"           # of a job; what is cut off goes on from its checkpoint in the next one
memory = "4 GB"         # the least a job asks for
cores = 16              # the most that one node of the study gets
modules = ["lammps"]
pack = "5 min"          # short nodes go into one job together, up to this
array = 1000            # jobs of one array
```

The store and the program must lie where the cluster's machines see them. Done means that the result is in the store: no
accounting is needed, and what `squeue` says is a hint. A job that is gone without a result is submitted again; one that
ends three times without coming any further has failed. Two studies that need the same node share its job.

Measured by `make scale` (`benches/scale.py`), the same study here and as jobs:

"""


def impacts(cells, velocities):
    text = ", ".join(f'"{v} km/s"' for v in velocities)
    return IMPACTS.replace("CELLS", str(cells)).replace("VELOCITIES", text)


class Study:
    """A folder with a study, run in one way."""

    def __init__(self, program, folder, text, name="study"):
        self.program, self.folder, self.name = program, folder, name
        folder.mkdir(exist_ok=True)
        (folder / f"{name}.toml").write_text(text)

    def start(self, executor):
        command = [self.program, "run", f"{self.name}.toml", "--store", "store", "--json", "--checkpoint", "2s"]
        log = open(self.folder / f"{self.name}.log", "wb")
        out = open(self.folder / f"{self.name}.json", "wb")
        return subprocess.Popen(command + ["--executor", executor], cwd=self.folder, stdout=out, stderr=log)

    def run(self, executor):
        start = time.monotonic()
        self.check(self.start(executor).wait())
        return time.monotonic() - start

    def check(self, code):
        if code != 0:
            sys.exit(f"{self.folder} ended with {code}:\n{(self.folder / f'{self.name}.log').read_text()}")

    def events(self, kind):
        lines = (self.folder / f"{self.name}.json").read_text().splitlines()
        return [e for e in map(json.loads, lines) if e["event"] == kind]

    def jobs(self):
        """Number of jobs, and of those that were submitted because an earlier one was gone."""
        queued = self.events("queued")
        return len({e["job"] for e in queued}), len(queued) - len({e["node"] for e in queued})

    def objects(self):
        return {p.parent.name + p.name: p.read_bytes() for p in (self.folder / "store/objects").rglob("*") if p.is_file()}


def compared(program, work, what, text, profile="", during=None):
    """A row: the study here and on the cluster, `during` being done to the cluster meanwhile."""
    here = Study(program, work / f"{what[:9].strip()} here".replace(" ", "-"), text)
    there = Study(program, work / f"{what[:9].strip()} there".replace(" ", "-"), f"[run.slurm]\n{profile}\n{text}")
    seconds = here.run("local")
    start = time.monotonic()
    process = there.start("slurm")
    if during:
        during()
    there.check(process.wait())
    remote = time.monotonic() - start
    same = here.objects() == there.objects()
    nodes = len(here.events("ran"))
    print(f"{what[2:]}: {seconds:.1f} s here, {remote:.1f} s there", file=sys.stderr)
    return [what, str(nodes), *map(str, there.jobs()), f"{seconds:.1f}", f"{remote:.1f}", "yes" if same else "NO"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "target/release/hvi-flow"))
    parser.add_argument("--nodes", type=int, default=1000, help="of the arrays of short nodes")
    parser.add_argument("--cells", type=int, default=26, help="of the impact that takes longer than its jobs may")
    parser.add_argument("--write", type=Path, help="also write the table to this file")
    args = parser.parse_args()
    work = Path(tempfile.mkdtemp(prefix="hvi-scale-"))
    work.chmod(0o755)
    cluster = str(work / "cluster")
    up = subprocess.run(["bash", SCRIPT, "up", cluster, str(os.getpid())], capture_output=True, text=True)
    if up.returncode != 0:
        sys.exit(up.stderr)
    os.environ["SLURM_CONF"] = up.stdout.split("=", 1)[1].strip()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))

    def control(command):
        subprocess.run(["bash", SCRIPT, command, cluster], check=True)

    def controller_dies():
        for _ in range(2):
            time.sleep(3)
            control("kill")
            time.sleep(2)
            control("again")

    version = subprocess.run(["sbatch", "--version"], capture_output=True, text=True).stdout.strip()
    try:
        short = SHORT.replace("COUNT", str(args.nodes))
        one_a_job = 'pack = "1 ms"'
        rows = [
            compared(args.program, work, f"1 {args.nodes} short nodes, packed", short),
            compared(args.program, work, f"2 {args.nodes} short nodes, ten a job", short, 'pack = "100 ms"'),
            compared(args.program, work, "3 a job for each short node", SHORT.replace("COUNT", str(args.nodes // 5)), one_a_job),
            compared(args.program, work, "4 impacts and a film", impacts(6, [1, 2, 3, 4])),
            compared(args.program, work, "5 a node longer than its job may be", impacts(args.cells, [2]), 'time = "1 min"'),
        ]
        a = Study(args.program, work / "both", short + impacts(6, [1, 2]), "a")
        b = Study(args.program, work / "both", short + impacts(6, [1, 2]), "b")
        here = Study(args.program, work / "both-here", short + impacts(6, [1, 2]))
        seconds = here.run("local")
        start = time.monotonic()
        for study, process in [(s, s.start("slurm")) for s in (a, b)]:
            study.check(process.wait())
        remote = time.monotonic() - start
        same = here.objects() == a.objects()
        jobs = len({e["job"] for s in (a, b) for e in s.events("queued")})
        again = sum(s.jobs()[1] for s in (a, b))
        rows += [["6 two studies at once, the same nodes", str(len(here.events("ran"))), str(jobs), str(again), f"{seconds:.1f}", f"{remote:.1f}", "yes" if same else "NO"]]
        rows.append(compared(args.program, work, "7 slurmctld killed twice with -9", short, 'pack = "100 ms"', controller_dies))
    finally:
        subprocess.run(["bash", SCRIPT, "down", cluster])
        shutil.rmtree(work, ignore_errors=True)
    rows = [[row[0][2:], *row[1:]] for row in rows]
    head = ["case", "nodes", "jobs", "submitted again", "here, s", "Slurm, s", "same digests"]
    lines = ["| " + " | ".join(head) + " |", "|---|---|---|---|---|---|---|"] + ["| " + " | ".join(r) + " |" for r in rows]
    text = "\n".join(lines) + f"\n\nMeasured on {os.cpu_count()} cores with {version}.\n"
    print(text)
    if args.write:
        about = __doc__.split("\n\n")[-1].strip()
        head = HEAD
        args.write.write_text(f"{head}{about}\n\n{text}")
    sys.exit(0 if all(row[-1] == "yes" for row in rows) else 1)


if __name__ == "__main__":
    main()
