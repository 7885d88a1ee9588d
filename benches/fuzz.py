"""libFuzzer on everything that is read: executions, what they covered, and what they found.

    make fuzz                            builds the targets, half an hour, writes docs/reliability.md
    python3 benches/fuzz.py --help

Each target of `fuzz/` reads bytes as one part of the program does: a pipeline file (read and planned), a potential file, a
description of an equation of state, a table like SESAME's, an STL surface, a store (index, record, recipe, object and
checkpoint, with seals that fit; then everything that is done with a store), a result (decoded and shown). A finding is a panic, an
overflow, a read outside of memory (AddressSanitizer), more than 4 GB, or more than 60 s; a result that makes no sense to its stage
may panic there, which the program catches and says. It begins with the files of
`fuzz/corpus`, which `make test` reads too, and with inputs that the program itself makes.

A nightly Rust and `cargo install cargo-fuzz` are needed.
"""
import os, re, shutil, subprocess, sys, tempfile
from pathlib import Path

from common import ROOT, Study, arguments, impact, machine, sweep, table, write_section

TARGETS = {
    "pipeline": "a pipeline file",
    "potential": "a potential file",
    "eos": "an equation of state",
    "sesame": "a table like SESAME's",
    "stl": "a surface",
    "store": "a store",
    "artifact": "a result",
}
CORPUS = ROOT / "fuzz/corpus"
# Longest input [B]; what is longer says nothing new, more slowly.
LONGEST = 8192


def seeds(program, into):
    """Inputs that the program takes, into a folder a target."""
    def put(target, name, data):
        folder = into / target
        folder.mkdir(parents=True, exist_ok=True)
        if len(data) <= LONGEST:
            (folder / name).write_bytes(data)

    for path in [*ROOT.glob("pipelines/*.toml"), *ROOT.glob("tests/bad/*.toml")]:
        put("pipeline", path.name, path.read_bytes())
    corners = [(0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    vertex = lambda i: "vertex {} {} {}\n".format(*corners[i])
    facets = ["facet normal 0 0 0\nouter loop\n" + "".join(map(vertex, f)) + "endloop\nendfacet\n" for f in faces]
    put("stl", "tetrahedron", ("solid part\n" + "".join(facets) + "endsolid part\n").encode())
    row = lambda scale: " ".join(f"{scale * i:.3f}" for i in range(20))
    setfl = f"a\nb\nc\n1 Cu\n20 0.1 20 0.28 5.5\n29 63.55 3.615 fcc\n{row(-0.1)}\n{row(0.3)}\n"
    put("potential", "setfl", f"s{setfl}{row(0.2)}\n".encode())
    put("potential", "finnis-sinclair", f"e{setfl}{row(0.2)}\n".encode())
    put("potential", "funcfl", f"fcopper\n29 63.55 3.615 fcc\n20 0.1 20 0.28 5.5\n{row(-0.1)}\n{row(0.3)}\n{row(0.2)}\n".encode())
    with tempfile.TemporaryDirectory() as work:
        film = '[step.film]\nuse = "radiograph"\nrun = "@hit"\nwidth = 16\n'
        study = Study(program, Path(work), sweep("[1.4, 1.5]") + impact(f'velocity = "2 km/s"\n{film}'))
        subprocess.run(study.command("-q"), cwd=work, check=True)
        for name in ["copper-royce", "copper-paper-md", "aluminium-paper"]:
            shown = study.hvi("eos", "show", name)
            if shown.returncode == 0:
                put("eos", name, shown.stdout.encode())
        grid = study.hvi("eos", "table", "copper-royce", "--density", "0.9", "1.2", "5", "--temperature", "200", "1000", "4")
        put("sesame", "copper-royce", grid.stdout.encode())
        objects = study.objects()
        for name, data in objects.items():
            put("artifact", data[:12].split(b"/")[0].decode("ascii", "replace") + "-" + name[:8], data)
        for path in sorted((study.store / "results").rglob("*")):
            if path.is_file():
                record = path.read_bytes().split(b"\n", 1)[1]
                recipe = (study.store / "recipes" / path.relative_to(study.store / "results")).read_bytes()
                data = next((d for d in objects.values() if len(d) < 2000 and str(len(d)).encode() in record), b"x")
                put("store", path.name[:12], b"q" + recipe + b"\0r" + record + b"\0i" + bytes(96) + b"\0f" + b"hvi-store/1\n")
                put("store", path.name[:12] + "-with", b"q" + recipe + b"\0o" + data.replace(b"\0", b"") + b"\0r" + record)


def fuzzed(binary, target, seconds, begin, folder):
    """A row of the table, and what was found."""
    corpus, found = folder / "corpus", folder / "found"
    corpus.mkdir(parents=True)
    found.mkdir()
    folders = [str(corpus), *(str(f) for f in (CORPUS / target, begin / target) if f.is_dir())]
    limits = [f"-max_total_time={seconds}", f"-max_len={LONGEST}", "-timeout=60", "-rss_limit_mb=4096", "-print_final_stats=1"]
    endless = ["-fork=1", "-ignore_crashes=1", "-ignore_ooms=1", "-ignore_timeouts=1"]
    run = subprocess.run(["nice", "-n", "19", binary, *folders, *limits, *endless, f"-artifact_prefix={found}/"], capture_output=True, text=True, errors="replace", cwd=folder, env={**os.environ, "TMPDIR": str(folder)})
    lines = re.findall(r"#(\d+): cov: (\d+) ft: (\d+) corp: (\d+)", run.stderr)
    executions, covered = (lines[-1][0], lines[-1][1]) if lines else ("0", "0")
    # What is merely slow (a shipped study of thousands of nodes is) is none.
    findings = sorted(p for p in found.iterdir() if not p.name.startswith("slow-unit"))
    for path in findings:
        print(f"{target}: {path.name}: {path.read_bytes()[:200]!r}", file=sys.stderr)
    if not lines:
        print(run.stderr[-3000:], file=sys.stderr)
    return [TARGETS[target], executions, covered, len(findings)], findings


def keep(binary, target, folder, begin, most):
    """The fewest inputs that cover what all cover, into the corpus of the tests: `most` of the smallest."""
    merged = folder / "merged"
    merged.mkdir()
    sources = [str(f) for f in (CORPUS / target, begin / target, folder / "corpus") if f.is_dir()]
    subprocess.run([binary, "-merge=1", "-timeout=60", "-rss_limit_mb=4096", str(merged), *sources], capture_output=True, cwd=folder)
    (CORPUS / target).mkdir(parents=True, exist_ok=True)
    for path in sorted(merged.iterdir(), key=lambda p: p.stat().st_size)[:most]:
        shutil.copy(path, CORPUS / target / path.name[:12])


def main():
    parser = arguments(__doc__)
    parser.add_argument("--targets", default=None, help="folder with the built targets, where not cargo-fuzz's own")
    parser.add_argument("--seconds", type=int, default=1800, help="of all targets together")
    parser.add_argument("--only", help="one target")
    parser.add_argument("--keep", type=int, default=0, help="so many of the inputs found go into fuzz/corpus, a target")
    parser.add_argument("--found", type=Path, default=Path("target/fuzz-found"), help="where inputs with findings go")
    args = parser.parse_args()
    built = Path(args.targets or ROOT / "fuzz/target/x86_64-unknown-linux-gnu/release")
    names = [args.only] if args.only else list(TARGETS)
    rows = []
    with tempfile.TemporaryDirectory(prefix="hvi-fuzz-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as work:
        begin = Path(work) / "seeds"
        seeds(args.program, begin)
        for name in names:
            folder = Path(work) / name
            row, findings = fuzzed(str(built / name), name, args.seconds // len(names), begin, folder)
            rows.append(row)
            print(row, file=sys.stderr, flush=True)
            for path in findings:
                args.found.mkdir(parents=True, exist_ok=True)
                shutil.copy(path, args.found / f"{name}-{path.name}")
            if args.keep:
                keep(str(built / name), name, folder, begin, args.keep)
    text = table(["read", "executions", "branches covered", "findings"], rows) + "\n"
    print(text)
    if args.write:
        about = __doc__.split("\n\n")[2]
        head = f"Made by `make fuzz` (`benches/fuzz.py`).\n\n{about}\n\n"
        tail = f"\n{args.seconds // 60} minutes in all, one process. {machine()}\n"
        write_section(args.write, "What faults do", "Fuzzing", head + text + tail)
    sys.exit(1 if any(row[3] for row in rows) else 0)


if __name__ == "__main__":
    main()
