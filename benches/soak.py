"""One store for minutes under everything at once: runs, edits, kills, damage, collection.

    make soak                            builds hvi-flow, 10 minutes, enters what was found into docs/reliability.md
    python3 benches/soak.py --help

Twelve studies that share most of their nodes live on one store. Again and again one of the operations below is done, drawn
at random, the same ones for the same seed. After each run that came to its end, its tables are held against those of a run on
a fresh store, and so is every result in the store now and then. Counted for each operation:

- wrong: a table or a result that isn't the right one, byte for byte, a panic, or an exit code of no meaning;
- lost: a run that did not come to its end, or damage that `cache verify` finds after `cache repair`.

At the end all studies run; the store must hold every result, `cache verify` find nothing, and nothing be left of what was killed.
"""
import random, shutil, signal, sys, tempfile, time
from pathlib import Path

from common import Study, arguments, impact, machine, sweep, table, write_section


def studies():
    """The text of each study."""
    films = '[step.film]\nuse = "radiograph"\nrun = "@hit"\nwidth = 32'
    for i in range(12):
        speed = 1 + i % 4
        yield sweep(f'"1.2 .. 1.6 in {5 + 4 * (i % 3)}"') + impact(f'velocity = "{speed} km/s"\n{films}')


class Soak:
    """The store, the studies on it, and what is right."""

    def __init__(self, program, work, seed):
        self.random = random.Random(seed)
        self.work, self.wrong, self.lost = work, 0, 0
        self.right, self.objects, self.studies = {}, {}, []
        for i, text in enumerate(studies()):
            fresh = Study(program, work / "fresh" / str(i), text, f"s{i}")
            process = fresh.start("-q")
            _, said = process.communicate()
            if process.returncode != 0:
                sys.exit(said)
            self.right[i] = self.tables(fresh)
            self.objects.update(fresh.objects())
            study = Study(program, work / "soak", text, f"s{i}")
            self.studies.append(study)
        self.store = self.studies[0].store

    @staticmethod
    def tables(study):
        folder = study.folder / "out" / study.name
        return {p.name: p.read_bytes() for p in folder.glob("*.csv")}

    def study(self):
        i = self.random.randrange(len(self.studies))
        return i, self.studies[i]

    def ended(self, i, process):
        """Takes in what came of a run that was to come to its end."""
        _, said = process.communicate()
        self.lost += process.returncode != 0
        self.wrong += "panicked" in said or process.returncode not in (0, 1)
        if process.returncode == 0:
            self.wrong += self.tables(self.studies[i]) != self.right[i]
        else:
            print(said, file=sys.stderr)

    def check_objects(self):
        for name, data in self.studies[0].objects().items():
            self.wrong += name not in self.objects or self.objects[name] != data

    def files(self):
        return [p for p in sorted(self.store.rglob("*")) if p.is_file()]

    # --- Operations ---

    def a_run(self):
        i, study = self.study()
        self.ended(i, study.start("--checkpoint", "1ms"))

    def two_runs_at_once(self):
        # Of studies with different names: each has its own folder for results.
        chosen = self.random.sample(range(len(self.studies)), 2)
        for i, process in [(i, self.studies[i].start("--checkpoint", "1ms")) for i in chosen]:
            self.ended(i, process)

    def kill_9_in_a_run(self):
        _, study = self.study()
        process = study.start("--checkpoint", "1ms")
        time.sleep(self.random.random() * 0.1)
        process.send_signal(signal.SIGKILL)
        process.communicate()

    def interrupt_in_a_run(self):
        _, study = self.study()
        process = study.start("--checkpoint", "1ms")
        time.sleep(self.random.random() * 0.1)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
        self.wrong += "panicked" in said or process.returncode not in (0, 130, -signal.SIGINT)

    def collection_beside_a_run(self):
        i, study = self.study()
        process = study.start("--checkpoint", "1ms")
        limit = self.random.choice([["--max-size", "20kB"], ["--older-than", "0s"], ["--max-size", "200kB"]])
        done = study.hvi("cache", "gc", *limit)
        self.wrong += "panicked" in done.stderr
        self.ended(i, process)

    def collection(self):
        _, study = self.study()
        done = study.hvi("cache", "gc", "--max-size", f"{self.random.randrange(200)}kB")
        self.lost += done.returncode != 0

    def a_file_of_the_store_damaged(self):
        files = self.files()
        if files:
            path = self.random.choice(files)
            data = bytearray(path.read_bytes())
            if data:
                data[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
            path.write_bytes(data)
        i, study = self.study()
        # A table that was written from the store is not read again: it is made anew here.
        shutil.rmtree(study.folder / "out" / study.name, ignore_errors=True)
        self.ended(i, study.start())
        # What no run has needed yet is found by `verify`; `repair` drops its record, and nothing is left to find.
        self.lost += study.hvi("cache", "verify").returncode not in (0, 1)
        self.lost += study.hvi("cache", "repair").returncode != 0
        self.lost += study.hvi("cache", "verify").returncode != 0
        self.check_objects()

    def files_removed(self):
        files = self.files()
        for path in self.random.sample(files, min(5, len(files))):
            path.unlink(missing_ok=True)
        i, study = self.study()
        self.ended(i, study.start())

    def a_table_edited(self):
        i, study = self.study()
        tables = sorted((study.folder / "out" / study.name).glob("*.csv"))
        if tables:
            self.random.choice(tables).write_bytes(b"edited")
        self.ended(i, study.start())

    def a_value_changed_and_put_back(self):
        i, study = self.study()
        text = (study.folder / f"{study.name}.toml").read_text()
        study.write(text.replace("width = 32", "width = 48"))
        changed = study.start()
        _, said = changed.communicate()
        self.lost += changed.returncode != 0
        for name, data in study.objects().items():
            self.objects.setdefault(name, data)
        study.write(text)
        self.ended(i, study.start())

    def looks(self):
        _, study = self.study()
        for command in (["status"], ["plan"], ["explain"], ["graph"]):
            done = study.hvi(*command, f"{study.name}.toml")
            self.lost += done.returncode != 0
            self.wrong += "panicked" in done.stderr

    def repair(self):
        done = self.studies[0].hvi("cache", "repair")
        self.lost += done.returncode != 0


OPERATIONS = [
    Soak.a_run, Soak.two_runs_at_once, Soak.kill_9_in_a_run, Soak.interrupt_in_a_run, Soak.collection_beside_a_run,
    Soak.collection, Soak.a_file_of_the_store_damaged, Soak.files_removed, Soak.a_table_edited,
    Soak.a_value_changed_and_put_back, Soak.looks, Soak.repair,
]


def main():
    parser = arguments(__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    work = Path(tempfile.mkdtemp(prefix="hvi-soak-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        soak = Soak(args.program, work, args.seed)
        counts = {operation: [0, 0, 0] for operation in OPERATIONS}
        end = time.monotonic() + 60 * args.minutes
        while time.monotonic() < end:
            operation = soak.random.choice(OPERATIONS)
            before = soak.wrong, soak.lost
            operation(soak)
            count = counts[operation]
            for k, more in enumerate([1, soak.wrong - before[0], soak.lost - before[1]]):
                count[k] += more
        before = soak.wrong, soak.lost
        for _ in range(2):
            for i, study in enumerate(soak.studies):
                soak.ended(i, study.start())
        soak.check_objects()
        study = soak.studies[0]
        soak.lost += study.hvi("cache", "repair").returncode != 0
        soak.lost += study.hvi("cache", "verify").returncode != 0
        left = [p for shelf in ("tmp", "partial") for p in (soak.store / shelf).rglob("*") if p.is_file()]
        soak.lost += len(left)
        last = [1, soak.wrong - before[0], soak.lost - before[1]]
    finally:
        shutil.rmtree(work, ignore_errors=True)
    rows = [[operation.__name__.replace("_", " ").replace("kill 9", "kill -9"), *count] for operation, count in counts.items()]
    rows += [["all studies at the end", *last], ["all", *(sum(row[k] for row in rows) + last[k - 1] for k in (1, 2, 3))]]
    text = table(["operation", "times", "wrong", "lost"], rows) + "\n\n" + f"{args.minutes:g} minutes, seed {args.seed}. {machine()}\n"
    print(text)
    if args.write:
        about = __doc__.split("--help\n\n")[1].strip()
        head = f"Made by `make soak` (`benches/soak.py`).\n\n{about}\n\n"
        write_section(args.write, "What faults do", "A soak", head + text)
    sys.exit(1 if soak.wrong or soak.lost else 0)


if __name__ == "__main__":
    main()
