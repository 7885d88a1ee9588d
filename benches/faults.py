"""Random faults under hvi-flow: how many gave a wrong result, lost one, or were recovered from.

    make faults                          builds hvi-flow, 3600 tries, writes docs/reliability.md
    python3 benches/faults.py --help

Each try begins with a store of its own, whole or empty. A fault is done to it, or to a run on it; a run follows, with the
cause still there; then the cause is taken away and the study runs twice more. Counted:

- wrong: a run showed a number that is not the right one, panicked, or ended with an exit code of no meaning (0 done, 1
  something failed and it says what, 2 the input is wrong; or aborted, saying so, where no memory is to be had);
- lost: in the end the store has not every result, byte for byte, or a run still computes what should be there;
- recovered: neither.

As root, so that file systems can be mounted and networks be parted; the runs without write permission are those of user 65534.
strace makes calls of the program fail, late, or its last.
"""
import concurrent.futures, os, random, shutil, signal, subprocess, sys, tempfile, time
from pathlib import Path

from common import ROOT, Study, arguments, impact, sweep, table, write_section

CHECK = """
[step.check]
use = "validate.isotherm"
eos = "@set"
data = "measured.csv"
"""
STUDY = sweep('"1.2 .. 1.6 in 12"') + CHECK + impact('velocity = "2 km/s"')
TABLES = ["metal.csv", "set.csv", "check.csv", "hit.csv"]
NOBODY = 65534


class Try(Study):
    """A folder with the study and a store."""

    def __init__(self, program, folder, whole, seed):
        super().__init__(program, folder, STUDY)
        self.whole = whole
        self.random = random.Random(seed)
        folder.chmod(0o777)
        shutil.copy(whole / "measured.csv", folder)
        self.panicked = self.odd = False

    def with_store(self):
        shutil.copytree(self.whole / "store", self.store)

    def command(self, *more):
        return super().command("--checkpoint", "1ms", "--keep-going", *more)

    def run(self, prefix=(), fresh=True, also=()):
        """Runs the study; with `fresh` it reads every result anew; it may end with a code of `also`. The exit code, and what it said."""
        if fresh:
            shutil.rmtree(self.folder / "out", ignore_errors=True)
        done = subprocess.run([*prefix, *self.command()], cwd=self.folder, capture_output=True, text=True, errors="replace")
        self.note(done.returncode, done.stderr, also)
        return done.returncode, done.stderr

    def note(self, code, said, also=()):
        self.panicked |= "panicked" in said
        self.odd |= code not in (0, 1, 2, *also)
        self.odd |= code not in (0, -signal.SIGKILL) and not said.strip()

    def least_memory(self):
        """The least limit on memory [B] with which the program starts at all, to a megabyte."""
        starts = lambda limit: self.hvi_with(["prlimit", f"--as={limit}"], "--version") == 0
        return next(limit for limit in range(8_000_000, 2**31, 1_000_000) if starts(limit))

    def hvi_with(self, prefix, *arguments):
        return subprocess.run([*prefix, str(self.program), *arguments], capture_output=True).returncode

    def in_store(self):
        return [p for p in sorted(self.store.rglob("*")) if p.is_file()]

    def tables_are_right(self, all_of_them):
        for name in TABLES:
            path = self.folder / "out/study" / name
            if path.exists():
                lines, right = path.read_text().splitlines(), (self.whole / "out/study" / name).read_text().splitlines()
                # Points without a result have a row with empty cells.
                if all_of_them and lines != right or any(l not in right and not l.endswith(",") for l in lines):
                    return False
            elif all_of_them:
                return False
        return True


# --- Faults. Each leaves the cause there and returns what takes it away. ---


def flip(t):
    t.with_store()
    path = t.random.choice(t.in_store())
    times = path.stat()
    data = bytearray(path.read_bytes())
    if data:
        data[t.random.randrange(len(data))] ^= 1 << t.random.randrange(8)
    path.write_bytes(data)
    if t.random.random() < 0.5:
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    t.run()


def truncate(t):
    t.with_store()
    path = t.random.choice(t.in_store())
    os.truncate(path, t.random.randrange(max(path.stat().st_size, 1)))
    t.run()


def remove(t):
    t.with_store()
    for path in t.random.sample(t.in_store(), t.random.randint(1, 5)):
        path.unlink()
    t.run()


def garbage(t):
    t.with_store()
    for path in t.random.sample(t.in_store(), t.random.randint(1, 5)):
        path.write_bytes(t.random.randbytes(t.random.randrange(400)))
    t.run()


def swap(t):
    """A file under another one's name."""
    t.with_store()
    a, b = t.random.sample(t.in_store(), 2)
    data = a.read_bytes()
    a.write_bytes(b.read_bytes())
    b.write_bytes(data)
    t.run()


def clock(t):
    """Times of files far in the past or the future."""
    t.with_store()
    for path in t.in_store():
        if t.random.random() < 0.5:
            when = t.random.randrange(2**32)
            os.utime(path, (when, when))
    t.run()


def kill(t):
    """kill -9 at a random time, several times in a row."""
    for _ in range(t.random.randint(1, 3)):
        process = subprocess.Popen(t.command(), cwd=t.folder, stderr=subprocess.PIPE, text=True)
        try:
            _, said = process.communicate(timeout=t.random.random() * 0.15)
            t.note(process.returncode, said)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def two_killed(t):
    """Two runs on one store, one of them killed with -9."""
    runs = [subprocess.Popen(t.command("--out", f"out{i}"), cwd=t.folder, stderr=subprocess.PIPE, text=True) for i in range(2)]
    time.sleep(t.random.random() * 0.1)
    runs[0].kill()
    runs[0].communicate()
    _, said = runs[1].communicate()
    t.note(runs[1].returncode, said)


def damaged_while_running(t):
    """A file cut short while a run uses the store."""
    t.with_store()
    shutil.rmtree(t.store / "results")
    (t.store / "index").unlink()
    process = subprocess.Popen(t.command(), cwd=t.folder, stderr=subprocess.PIPE, text=True)
    time.sleep(t.random.random() * 0.06)
    files = t.in_store()
    if files:
        try:
            os.truncate(t.random.choice(files), 3)
        except FileNotFoundError:
            pass
    _, said = process.communicate()
    t.note(process.returncode, said)


def as_nobody(t):
    return ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]


def permission(t):
    """A folder or a file of the store that may not be read, written, or entered."""
    t.with_store()
    below = sorted(t.store.rglob("*"))
    if t.random.random() < 0.5:
        below = [p for p in below if p.is_dir()]
    path = t.random.choice(below)
    for p in [t.store, *t.store.rglob("*")]:
        os.chown(p, NOBODY, NOBODY)
    old = path.stat().st_mode & 0o777
    path.chmod(t.random.choice([0, 0o400, 0o500]))
    t.run(prefix=as_nobody(t))
    path.chmod(old)


def read_only(t):
    """A store with half of the results, on which nothing can be written."""
    t.with_store()
    for path in [p for p in t.in_store() if "results" in p.parts and t.random.random() < 0.5]:
        path.unlink()
    (t.store / "index").unlink()
    script = 'mount --bind store store; mount -o remount,bind,ro store; exec "$@"'
    t.run(prefix=["unshare", "--mount", "--propagation", "private", "sh", "-euc", script, "sh"])


def full(t):
    """A store on a file system of a few kilobytes."""
    t.store.mkdir()
    size = t.random.randrange(8, 700)
    script = f'mount -t tmpfs -o size={size}k tmpfs store; "$@" || code=$?; cp -r store saved; exit ${{code:-0}}'
    t.run(prefix=["unshare", "--mount", "--propagation", "private", "sh", "-euc", script, "sh"])
    t.store.rmdir()
    (t.folder / "saved").rename(t.store)


def results_edited(t):
    """A result for people, in out/, changed by hand."""
    t.with_store()
    t.run()
    path = t.random.choice([p for p in (t.folder / "out").rglob("*") if p.is_file()])
    path.write_bytes(t.random.randbytes(50))
    t.run(fresh=False)


# What a program does to files. Where strace stops it at one of them, the file system did.
CALLS = ["openat", "rename", "mkdir", "write", "ftruncate", "unlink", "flock", "statx", "newfstatat", "read"]


def strace(*inject):
    return ["strace", "-f", "-qqq", "-o", "/dev/null", *(word for what in inject for word in ("-e", f"inject={what}"))]


def call_fails(t):
    """One call, the N-th of its kind, or all from the N-th on, fail as on a broken disk, a full one, one that is forbidden."""
    if t.random.random() < 0.5:
        t.with_store()
        shutil.rmtree(t.store / "results")
        (t.store / "index").unlink()
    call = t.random.choice(CALLS[:7])
    error = t.random.choice(["EIO", "ENOSPC", "EACCES", "EDQUOT", "EROFS", "ENOENT"])
    # What can't be said can't be heard: of writes only one fails. The first files opened are the program's own libraries.
    first = t.random.randrange(20 if call == "openat" else 1, 150)
    t.run(prefix=strace(f"{call}:error={error}:when={first}{'' if call == 'write' else t.random.choice(['', '+'])}"))


def killed_at_a_call(t):
    """kill -9 at the N-th call of a kind."""
    if t.random.random() < 0.5:
        t.with_store()
        shutil.rmtree(t.store / "results")
        (t.store / "index").unlink()
    call = t.random.choice(CALLS[:7])
    t.run(prefix=strace(f"{call}:signal=KILL:when={t.random.randrange(1, 150)}"), also=[-signal.SIGKILL])


def slow_disk(t):
    """Every call of four kinds takes milliseconds longer."""
    if t.random.random() < 0.3:
        t.with_store()
    calls = ",".join(t.random.sample(CALLS, 4))
    code, _ = t.run(prefix=strace(f"{calls}:delay_enter={t.random.randrange(100, 4000)}"))
    t.odd |= code != 0


def out_of_memory(t):
    """A limit on memory within which the study may or may not fit. Rust ends a program that gets none, in words."""
    limit = t.least_memory() + int(300e6 * t.random.random() ** 3)
    code, said = t.run(prefix=["prlimit", f"--as={limit}"], also=[-signal.SIGABRT])
    t.odd |= code == -signal.SIGABRT and "memory allocation" not in said


def two_machines(t):
    """Two runs on one store, each on a machine of its own: its own network, processes, name, clock of processes' numbers. One may be lost."""
    machine = ["unshare", "--net", "--pid", "--uts", "--ipc", "--mount-proc", "--fork", "--kill-child", "sh", "-c"]
    script = 'hostname "$0"; "$@" & wait $!'
    runs = [
        subprocess.Popen([*machine, script, f"machine{i}", *t.command("--out", f"out{i}")], cwd=t.folder, stderr=subprocess.PIPE, text=True)
        for i in range(2)
    ]
    if t.random.random() < 0.5:
        time.sleep(t.random.random() * 0.15)
        runs[0].kill()
        runs[0].communicate()
        runs = runs[1:]
    for run in runs:
        _, said = run.communicate()
        t.note(run.returncode, said)
        t.odd |= run.returncode != 0


CASES = {
    "a bit flipped, in any file of the store": flip,
    "a file cut short": truncate,
    "files removed": remove,
    "files overwritten with noise": garbage,
    "two files exchanged": swap,
    "clock jumps: times of files far off": clock,
    "kill -9 in a run": kill,
    "kill -9 at a call, any that changes files": killed_at_a_call,
    "kill -9 in one of two runs": two_killed,
    "two machines on one store, one lost or none": two_machines,
    "a file cut short under a run": damaged_while_running,
    "permission lost": permission,
    "a store that can't be written": read_only,
    "disk full": full,
    "a call fails, any that changes files": call_fails,
    "a slow disk": slow_disk,
    "out of memory": out_of_memory,
    "a result for people edited": results_edited,
}


def one(case, program, whole, work, seed):
    """Whether a try was wrong, lost, and what it said then."""
    folder = Path(tempfile.mkdtemp(dir=work))
    t = Try(program, folder / "try", whole, seed)
    folder.chmod(0o777)
    try:
        CASES[case](t)
        wrong = not t.tables_are_right(False)
        code, said = t.run()
        wrong |= not t.tables_are_right(code == 0)
        code_again, again = t.run()
        right = Study(program, whole, STUDY).objects()
        # Copies of input files are put right when a node reads them.
        right = {name: data for name, data in right.items() if not data.startswith(b"file/")}
        found = t.objects()
        lost = code_again != 0 or not t.tables_are_right(True) or " 0 computed" not in again
        lost |= any(found.get(name) != data for name, data in right.items())
        bad = wrong or t.panicked or t.odd
        return bad, lost, f"{case}, seed {seed}: codes {code} {code_again}\n{said}{again}" if bad or lost else ""
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = arguments(__doc__)
    parser.add_argument("--tries", type=int, default=3600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", help="only cases whose name contains this")
    args = parser.parse_args()
    if os.geteuid() != 0:
        sys.exit("faults: file systems are mounted here, so this must be run by root")
    if not shutil.which("strace"):
        sys.exit("faults: strace is missing: apt-get install strace")
    work = Path(tempfile.mkdtemp(prefix="hvi-faults-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    work.chmod(0o777)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        # Where user 65534 can run it.
        program = shutil.copy(args.program, work / "hvi-flow")
        whole = work / "whole"
        study = Study(program, whole, STUDY)
        shutil.copy(ROOT / "pipelines/data/cu_isotherm_dewaele2004.csv", whole / "measured.csv")
        subprocess.run(study.command("-q"), cwd=whole, check=True)
        cases = [c for c in CASES if not args.case or args.case in c]
        each = -(-args.tries // len(cases))
        start = time.monotonic()
        counts = {c: [0, 0, 0, 0] for c in cases}
        jobs = [(c, args.seed * 1_000_000 + k * each + i) for k, c in enumerate(cases) for i in range(each)]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for (case, _), (wrong, lost, said) in zip(jobs, pool.map(lambda j: one(j[0], program, whole, work, j[1]), jobs)):
                count = counts[case]
                for i, yes in enumerate([True, wrong, lost, not wrong and not lost]):
                    count[i] += yes
                if said:
                    print(said, file=sys.stderr)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    total = [sum(c[i] for c in counts.values()) for i in range(4)]
    rows = [[case, *count] for case, count in counts.items()] + [["all", *total]]
    text = table(["case", "tries", "wrong", "lost", "recovered"], rows) + "\n"
    print(text + f"{time.monotonic() - start:.0f} s")
    if args.write:
        about = __doc__.split("Each try begins")[1].rsplit("\n\nAs root", 1)[0]
        head = f"Made by `make faults` (`benches/faults.py`), seed {args.seed}.\n\nEach try begins{about}\n\n"
        write_section(args.write, "What faults do", "Random faults", head + text)
    sys.exit(1 if total[1] or total[2] else 0)


if __name__ == "__main__":
    main()
