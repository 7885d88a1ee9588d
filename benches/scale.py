"""The same studies on this machine and as jobs of a real Slurm cluster of one node: the same digests?

    make scale                           builds hvi-flow, starts a private cluster, writes docs/scale.md; some twelve minutes
    python3 benches/scale.py --short     the same in three minutes, smaller

The cluster is that of the tests (`tests/slurm.sh`): slurmctld, slurmd and munged on the loopback. It has two job slots a
core, so times say what Slurm costs, not what a cluster gains.
"""
import json, os, shutil, signal, subprocess, sys, tempfile, time
from pathlib import Path

import common
from common import ROOT, arguments, machine, sweep, table

SCRIPT = ROOT / "tests/slurm.sh"
HEAD = """# Studies on a cluster

    hvi-flow run study.toml --executor slurm    submits what isn't in the store, and waits; Ctrl-C leaves the jobs, the same
                                                command returns to them
    hvi-flow cancel study.toml                  ends them

Or in the pipeline, or in a file that it includes, which is then a profile of the cluster; nothing of it enters a key:

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
ends three times without coming any further has failed. Two studies that need the same node share its job. Jobs are known by
names that nobody else has, never by Slurm's numbers, which a controller that lost its state gives out again. Where no machine
takes jobs (drained, down), that is said once, and the run waits. Large states of LAMMPS run as several processes by MPI: `ranks` of
the stage `md`.

Measured by `make scale` (`benches/scale.py`), the same study here and as jobs:

"""


# Of one run [s]: what takes longer waits for something that doesn't come.
LONGEST = 900

# An impact that keeps no picture of the time at which its film asks for one.
FAILS = common.impact('velocity = "2 km/s"\n[step.film]\nuse = "radiograph"\nrun = "@hit"\nexposures = ["0.05 us"]\n')


def short(count):
    return sweep(f'"1.2 .. 1.6 in {count}"')


def impacts(cells, velocities):
    text = ", ".join(f'"{v} km/s"' for v in velocities)
    more = f'sweep = {{ velocity = [{text}] }}\n[step.film]\nuse = "radiograph"\nrun = "@hit[velocity=2 km/s]"\nwidth = 64'
    return common.impact(more, cells, width="3 mm", end="3 us")


class Study(common.Study):
    """A folder with a study, run in one way."""

    def begin(self, executor):
        log = open(self.folder / f"{self.name}.log", "wb")
        out = open(self.folder / f"{self.name}.json", "wb")
        command = self.command("--json", "--checkpoint", "2s", "--keep-going", "--executor", executor)
        return subprocess.Popen(command, cwd=self.folder, stdout=out, stderr=log)

    def run(self, executor, right=0):
        start = time.monotonic()
        self.check(self.begin(executor).wait(LONGEST), right)
        return time.monotonic() - start

    def check(self, code, right=0):
        if code != right:
            sys.exit(f"{self.folder} ended with {code}:\n{(self.folder / f'{self.name}.log').read_text()}")

    def events(self, kind):
        lines = (self.folder / f"{self.name}.json").read_text().splitlines()
        return [e for e in map(json.loads, lines) if e["event"] == kind]

    def jobs(self):
        """Number of jobs, and of those that were submitted because an earlier one was gone."""
        queued = self.events("queued")
        return len({e["job"] for e in queued}), len(queued) - len({e["node"] for e in queued})


def compared(program, work, what, text, profile="", during=None, right=0):
    """A row: the study here and on the cluster, `during` being done to the cluster meanwhile; both end with the code `right`."""
    here = Study(program, work / f"{what[:9].strip()} here".replace(" ", "-"), text)
    there = Study(program, work / f"{what[:9].strip()} there".replace(" ", "-"), f"[run.slurm]\n{profile}\n{text}")
    seconds = here.run("local", right)
    start = time.monotonic()
    process = there.begin("slurm")
    if during:
        during()
    there.check(process.wait(LONGEST), right)
    remote = time.monotonic() - start
    same = here.objects() == there.objects()
    nodes = len(here.events("ran"))
    print(f"{what[2:]}: {seconds:.1f} s here, {remote:.1f} s there", file=sys.stderr)
    return [what, str(nodes), *map(str, there.jobs()), f"{seconds:.1f}", f"{remote:.1f}", "yes" if same else "NO"]


CORES = [100, 1000]


def full_study(args):
    """What the paper's full study takes, by the program's own foresight: core-hours by stage, and packed onto clusters."""
    pipeline = ROOT / "pipelines/copper-paper.toml"
    with tempfile.TemporaryDirectory() as folder:
        command = [args.program, "plan", str(pipeline), "--store", f"{folder}/store", "--cores", ",".join(map(str, CORES)), "--json"]
        figures = ["--figures", str(args.write.parent)] if args.write else []
        found = json.loads(subprocess.run(command + figures, check=True, capture_output=True).stdout)
    hours = lambda seconds: f"{seconds / 3600:.3g}"
    stages = [[s["stage"], s["nodes"], hours(s["core_s"]), hours(s["longest_core_s"])] for s in found["stages"]]
    stages.append(["all", sum(s["nodes"] for s in found["stages"]), hours(found["cost_s"]), ""])
    packed = [[p["cores"], hours(p["makespan_s"]), f"{100 * p['utilisation']:.1f}", hours(p["longest_way_s"])] for p in found["packings"]]
    pictures = [f"![Cores at work over time, {n} cores](copper-paper-on-{n}-cores.svg)" for n in CORES]
    return "\n\n".join([
        "## The paper's full study",
        f"    hvi-flow plan pipelines/copper-paper.toml --cores {','.join(map(str, CORES))} --figures docs",
        "Foretold for an empty store by each stage's own model of its time (where a store has results, by what they took):",
        table(["stage", "nodes", "core-hours", "longest node on one core, h"], stages),
        "Packed onto machines of 64 cores by a simulated schedule, the node with the longest way to the end first:",
        table(["cores", "from begin to end, h", "cores' time used, %", "longest way, h"], packed),
        *pictures, S3,
    ]) + "\n"


S3 = """## A store in a bucket

    cargo build --release --features s3
    export AWS_ENDPOINT_URL=https://s3.example.org AWS_REGION=... AWS_ACCESS_KEY_ID=... AWS_SECRET_ACCESS_KEY=...
    hvi-flow run study.toml --second-store s3://team/hvi    # what the store lacks is read from there
    hvi-flow cache push s3://team/hvi                       # what was computed, for the others
    hvi-flow cache pull s3://team/hvi                       # all of it, to go on without a network

What arrives is checked by its digest. A service that is out of reach, a bucket that isn't there or keys that don't fit are
named in one line, and the run goes on without."""


def main():
    parser = arguments(__doc__)
    parser.add_argument("--nodes", type=int, default=1000, help="of the arrays of short nodes")
    parser.add_argument("--short", action="store_true", help="a fifth of the nodes, and no job that runs out of time: some two minutes")
    parser.add_argument("--cells", type=int, default=60, help="of the impact that takes longer than its jobs may")
    args = parser.parse_args()
    if args.short:
        args.nodes //= 5
    work = Path(tempfile.mkdtemp(prefix="hvi-scale-"))
    work.chmod(0o755)
    cluster = str(work / "cluster")
    up = subprocess.run(["bash", SCRIPT, "up", cluster, str(os.getpid())], capture_output=True, text=True)
    if up.returncode != 0:
        sys.exit(up.stderr)
    os.environ["SLURM_CONF"] = up.stdout.split("=", 1)[1].strip()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))

    def control(command):
        subprocess.run(["bash", SCRIPT, command, cluster], check=True, timeout=180)

    def controller_dies():
        for _ in range(2):
            time.sleep(3)
            control("kill")
            time.sleep(2)
            control("again")

    version = subprocess.run(["sbatch", "--version"], capture_output=True, text=True).stdout.strip()
    try:
        many = short(args.nodes)
        one_a_job = 'pack = "1 ms"'
        rows = [
            compared(args.program, work, f"1 {args.nodes} short nodes, packed", many),
            compared(args.program, work, f"2 {args.nodes} short nodes, ten a job", many, 'pack = "10 ms"'),
            compared(args.program, work, f"3 an array of {args.nodes} jobs, one a node", many, one_a_job),
            compared(args.program, work, "4 impacts and a film", impacts(6, [1, 2, 3, 4])),
        ]
        if not args.short:
            rows.append(compared(args.program, work, "5 a node longer than its job may be", impacts(args.cells, [2]), 'time = "1 min"'))
        a = Study(args.program, work / "both", many + impacts(6, [1, 2]), "a")
        b = Study(args.program, work / "both", many + impacts(6, [1, 2]), "b")
        here = Study(args.program, work / "both-here", many + impacts(6, [1, 2]))
        seconds = here.run("local")
        start = time.monotonic()
        for study, process in [(s, s.begin("slurm")) for s in (a, b)]:
            study.check(process.wait(LONGEST))
        remote = time.monotonic() - start
        same = here.objects() == a.objects()
        jobs = len({e["job"] for s in (a, b) for e in s.events("queued")})
        again = sum(s.jobs()[1] for s in (a, b))
        rows += [["6 two studies at once, the same nodes", str(len(here.events("ran"))), str(jobs), str(again), f"{seconds:.1f}", f"{remote:.1f}", "yes" if same else "NO"]]
        rows.append(compared(args.program, work, "7 slurmctld killed twice with -9", many, 'pack = "10 ms"', controller_dies))
        rows.append(compared(args.program, work, "8 a node that fails, others that don't", many + FAILS, right=1))
    finally:
        subprocess.run(["bash", SCRIPT, "down", cluster])
        shutil.rmtree(work, ignore_errors=True)
    rows = [[row[0][2:], *row[1:]] for row in rows]
    head = ["case", "nodes", "jobs", "submitted again", "here, s", "Slurm, s", "same digests"]
    text = table(head, rows) + f"\n\n{machine()} {version}.\n\n" + full_study(args)
    print(text)
    if args.write:
        about = __doc__.split("\n\n")[-1].strip()
        args.write.write_text(f"{HEAD}{about}\n\n{text}")
    sys.exit(0 if all(row[-1] == "yes" for row in rows) else 1)


if __name__ == "__main__":
    main()
