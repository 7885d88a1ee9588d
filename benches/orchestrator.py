"""The orchestrator beside its peers: CPU time and memory of whole processes, and six cases that a content cache must get right.

    make bench                        builds hvi-flow, installs the peers into target/bench/venv, writes docs/orchestrator.md
    python3 benches/orchestrator.py --help

Every peer's stage copies a file of 1 kB, one job at a time. hvi-flow's stage is `eos.handbook`, its cheapest real one:
each node of the sweep makes a Mie-Grueneisen equation of state. CPU is user + system time of the process and all its
children, the median over rounds in which the tools take turns.
"""
import json, os, random, shutil, signal, statistics, subprocess, sys, time
from pathlib import Path

from common import ROOT, Study, arguments, impact, machine, sweep, table

PEERS = {"make": None, "ninja": "ninja", "doit": "doit", "snakemake": "snakemake", "dvc": "dvc"}


def measure(command, folder, env=None):
    """Runs a command: CPU seconds, wall seconds, peak memory in MB."""
    start = time.monotonic()
    with open(folder / ".bench.log", "wb") as log:
        process = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env={**os.environ, **(env or {})})
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{command} in {folder} ended with {process.returncode}:\n{(folder / '.bench.log').read_text()}")
    return {"cpu": usage.ru_utime + usage.ru_stime, "wall": time.monotonic() - start, "memory": usage.ru_maxrss / 1024}


def install(tools, work):
    """Puts the peers into a venv of their own; returns the command of each that is there, and what is missing."""
    venv, found, missing = work / "venv", {}, {}
    wanted = [t for t in tools if PEERS[t]]
    if wanted and not (venv / "bin/pip").exists():
        subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    for tool in tools:
        program = shutil.which(tool) if PEERS[tool] is None else str(venv / "bin" / tool)
        if PEERS[tool] and not Path(program).exists():
            pip = subprocess.run([venv / "bin/pip", "install", "-q", PEERS[tool]], capture_output=True, text=True)
            if pip.returncode != 0:
                missing[tool] = pip.stderr.strip().splitlines()[-1:]
                continue
        if program is None:
            missing[tool] = "not installed"
        else:
            found[tool] = program
    return found, missing


class HviFlow(Study):
    """hvi-flow on a sweep of n points."""

    def __init__(self, program, folder, n):
        self.n, self.first = n, 1.0
        super().__init__(program, folder, self.text())

    def text(self):
        slopes = [self.first] + [1.0 + 0.5 * i / self.n for i in range(1, self.n)]
        return sweep("[" + ", ".join(map(repr, slopes)) + "]")

    def run(self):
        return measure(self.command("-q"), self.folder)

    def find(self):
        """Finds what is to run, and runs nothing."""
        return measure([self.program, "plan", "study.toml", "--store", str(self.store)], self.folder)

    def change_one(self, i):
        self.first = 1.0 + 1e-6 * (i + 1)
        self.write(self.text())

    def touch(self):
        for path in [self.folder / "study.toml", *(self.store / "objects").rglob("*")]:
            os.utime(path)

    def last_node(self):
        """CPU seconds of the node that was computed last, by its record."""
        records = [p for p in (self.store / "results").rglob("*") if p.is_file()]
        last = max(records, key=lambda p: p.stat().st_mtime_ns)
        return json.loads(last.read_text().split("\n", 1)[1])["cpu_s"]


class Peer:
    """A peer on n stages that copy in/N to out/N."""

    def __init__(self, tool, program, folder, n):
        self.tool, self.folder, self.n = tool, folder, n
        (folder / "in").mkdir(parents=True)
        (folder / "out").mkdir()
        for i in range(n):
            self.input(i, i)
        names = range(n)
        if tool == "make":
            rule = "all: $(patsubst in/%,out/%,$(wildcard in/*))\nout/%: in/%\n\t@cp $< $@\n"
            (folder / "Makefile").write_text(rule)
            self.command = [program, "-s"]
        elif tool == "ninja":
            rules = "rule cp\n  command = cp $in $out\n" + "".join(f"build out/{i}: cp in/{i}\n" for i in names)
            (folder / "build.ninja").write_text(rules)
            self.command = [program, "-j1", "--quiet"]
        elif tool == "doit":
            task = "{'name': str(i), 'actions': [f'cp in/{i} out/{i}'], 'file_dep': [f'in/{i}'], 'targets': [f'out/{i}']}"
            (folder / "dodo.py").write_text(f"def task_cp():\n    for i in range({n}):\n        yield {task}\n")
            self.command = [program, "-v0"]
        elif tool == "snakemake":
            rule = 'rule cp:\n    input: "in/{i}"\n    output: "out/{i}"\n    shell: "cp {input} {output}"\n'
            (folder / "Snakefile").write_text(f'rule all:\n    input: [f"out/{{i}}" for i in range({n})]\n{rule}')
            self.command = [program, "-j1", "-q", "all"]
        elif tool == "dvc":
            subprocess.run([program, "init", "-q", "--no-scm"], cwd=folder, check=True)
            stages = {f"s{i}": {"cmd": f"cp in/{i} out/{i}", "deps": [f"in/{i}"], "outs": [f"out/{i}"]} for i in names}
            (folder / "dvc.yaml").write_text(json.dumps({"stages": stages}))
            self.command = [program, "repro", "-q"]

    def input(self, i, seed):
        (self.folder / f"in/{i}").write_bytes(random.Random(seed).randbytes(1024))

    def run(self):
        env = {"PATH": f"{Path(self.command[0]).parent}:{os.environ['PATH']}", "DVC_NO_ANALYTICS": "1"}
        return measure(self.command, self.folder, env)

    def change_one(self, i):
        time.sleep(0.02)
        self.input(0, 10_000_000 + i)

    def touch(self):
        time.sleep(0.02)
        for path in (self.folder / "in").iterdir():
            os.utime(path)


def speeds(studies, rounds):
    """For each study the medians of its phases, the tools taking turns."""
    found = {name: {"cold": study.run()} for name, study in studies.items()}
    for phase, prepare in [("no-op", None), ("one changed", "change_one"), ("touched", "touch")]:
        runs = {name: [] for name in studies}
        for i in range(rounds):
            for name, study in studies.items():
                if prepare == "change_one":
                    study.change_one(i)
                elif prepare:
                    study.touch()
                elif i == 0:
                    study.run()  # what it does once after new results, as reading them again
                runs[name].append(study.run())
        for name, all_runs in runs.items():
            found[name][phase] = {k: statistics.median(r[k] for r in all_runs) for k in all_runs[0]}
    return found


SCENE = impact('velocity = "2 km/s"\n[step.film]\nuse = "radiograph"\nrun = "@hit"\nwidth = 64', width="3 mm", end="0.3 us")


class Chain(Study):
    """Three stages of hvi-flow: set -> hit -> film."""

    def __init__(self, program, folder):
        super().__init__(program, folder, SCENE)

    def run(self):
        """Number of stages that were computed."""
        process = self.start()
        _, said = process.communicate()
        if process.returncode != 0:
            sys.exit(said)
        return int(said.split(" computed")[0].split()[-1])

    def edited(self, step):
        """Whether a result of `step` that was edited by hand is put back, and nothing computed for it."""
        path = self.folder / "out/study" / f"{step}.csv"
        before = path.read_bytes()
        path.write_bytes(b"edited by hand")
        return self.run() == 0 and path.read_bytes() == before


def one_changed(program, folder, n, rounds):
    """What a changed node of n costs besides its own work: medians [s] of the whole run, of one that changes nothing, of finding
    the node, and of the node by its record."""
    study = HviFlow(program, folder, n)
    for _ in range(2):
        study.run()
    found = []
    for i in range(rounds):
        study.run()
        nothing = study.run()["cpu"]
        study.change_one(i)
        finding = study.find()["cpu"]
        found.append((study.run()["cpu"], nothing, finding, study.last_node()))
    return [statistics.median(column) for column in zip(*found)]


def six_cases(program, work):
    """The six cases, each with what it must show."""
    chain = Chain(program, work / "chain")
    assert chain.run() == 3
    objects, out = chain.files("store/objects"), chain.files("out")
    cases = {}
    first = next(p for p, b in objects.items() if b.startswith(b"eos/"))
    first.unlink()
    cases["first stage reruns with the same output: the rest stay"] = chain.run() == 1
    chain.write(SCENE.replace("2 km/s", "2.1 km/s"))
    changed = chain.run()
    chain.write(SCENE)
    cases["input goes back to an older value: nothing reruns"] = changed == 2 and chain.run() == 0
    cases["final output edited by hand: put back"] = chain.edited("film")
    cases["middle output edited by hand: put back, the next stage stays"] = chain.edited("hit")
    for path, good in objects.items():
        bad = bytearray(good)
        bad[len(bad) // 2] ^= 1
        path.write_bytes(bad)
    again = chain.run() == 3 and all(path.read_bytes() == good for path, good in objects.items())
    cases["cached objects damaged: never served, computed again"] = again
    killed = Chain(program, work / "killed")
    for i in range(20):
        process = killed.start()
        time.sleep(0.02 * i)
        process.send_signal(signal.SIGKILL)
        process.communicate()
    killed.run()
    same = {p.name: b for p, b in killed.files("store/objects").items()} == {p.name: b for p, b in objects.items()}
    cases["kill -9 at 20 moments, then run again: the same results"] = same and killed.run() == 0
    return cases


def milliseconds(run):
    return f"{1e3 * run['cpu']:.1f}"


def main():
    parser = arguments(__doc__)
    parser.add_argument("--work", type=Path, default=ROOT / "target/bench")
    parser.add_argument("--peers", nargs="*", choices=list(PEERS), default=list(PEERS))
    parser.add_argument("--stages", type=int, default=1000, help="of make, ninja and doit, and of hvi-flow")
    parser.add_argument("--slow-stages", type=int, default=200, help="of Snakemake and DVC, which take minutes for 1000")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--most", type=int, default=100_000, help="nodes of hvi-flow's largest sweep")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    peers, missing = install(args.peers, args.work)
    work = args.work / "runs"
    if work.exists():
        shutil.rmtree(work)
        # ext4 passes by what was removed in the last five seconds, one by one, wherever something new is made.
        time.sleep(6)

    quick = {"hvi-flow": HviFlow(args.program, work / "hvi-flow", args.stages)}
    slow = {}
    for tool, program in peers.items():
        is_slow = tool in ("snakemake", "dvc")
        n = args.slow_stages if is_slow else args.stages
        (slow if is_slow else quick)[tool] = Peer(tool, program, work / tool, n)
    found = {**speeds(quick, args.rounds), **speeds(slow, min(args.rounds, 3))}
    rows = []
    for name, study in {**quick, **slow}.items():
        f = found[name]
        memory = f"{max(run['memory'] for run in f.values()):.0f}"
        rows.append([name, str(study.n), *(milliseconds(f[p]) for p in ["cold", "no-op", "one changed", "touched"]), memory])
    head = ["tool", "stages", "cold", "no-op", "one changed", "all touched", "memory, MB"]
    parts = [f"CPU time in ms (user + system), median of {args.rounds} rounds:", table(head, rows)]
    parts += [f"Not measured: {tool}: {why}" for tool, why in missing.items()]

    rows, n = [], args.stages
    while n <= args.most:
        study = HviFlow(args.program, work / f"sweep-{n}", n)
        cold = study.run()
        study.run()
        again = [study.run() for _ in range(args.rounds)]
        median = {k: statistics.median(r[k] for r in again) for k in cold}
        per_node = f"{1e6 * median['cpu'] / n:.1f}"
        rows.append([str(n), f"{1e3 * cold['cpu'] / n:.2f}", milliseconds(median), per_node, f"{median['memory']:.0f}"])
        n *= 10
    head = ["nodes", "cold, ms a node", "no-op, ms", "no-op, us a node", "no-op memory, MB"]
    parts += ["hvi-flow alone, by size of the sweep:", table(head, rows)]

    rounds = 4 * args.rounds + 1
    whole, nothing, finding, own = one_changed(args.program, work / "one-changed", args.stages, rounds)
    row = [args.stages, *(f"{1e3 * s:.1f}" for s in (nothing, finding, whole, own, whole - own))]
    head = ["nodes", "run that changes nothing, ms", "finding the change (`plan`), ms", "whole run, ms", "the node by its record, ms", "besides the node, ms"]
    parts += [f"One node changed: it is found, computed, and all tables and the report are brought up to date (medians of {rounds}):"]
    parts += [table(head, [row])]

    cases = six_cases(args.program, work)
    parts += ["Six cases that a content cache must get right, on a chain of three stages of hvi-flow:"]
    parts += [table(["case", "right"], [[case, "yes" if right else "NO"] for case, right in cases.items()])]
    parts += [machine()]
    text = "\n\n".join(parts) + "\n"
    print(text)
    if args.write:
        args.write.write_text("# The orchestrator, measured\n\nMade by `make bench` (`benches/orchestrator.py`).\n\n" + text)
    if not all(cases.values()):
        sys.exit("a case went wrong")


if __name__ == "__main__":
    main()
