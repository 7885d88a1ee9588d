"""The unsafe parts under AddressSanitizer and Miri.

    make sanitize                        builds and runs them, writes docs/reliability.md; a quarter of an hour
    python3 benches/sanitize.py --help

AddressSanitizer sees reads and writes outside of what was asked for, on all instruction sets that the processor has; Miri knows
the rules of the language, but few of the processor's instructions, and is a thousand times slower, so it gets small tests. Neither
was asked about races between threads: that results have the same bits for any number of threads is what the tests hold. A finding
ends a test.

A nightly Rust with `miri` is needed.
"""
import os, re, subprocess, sys, time
from pathlib import Path

from common import ROOT, arguments, machine, table, write_section

TARGET = "x86_64-unknown-linux-gnu"
ADDRESS, MIRI = "AddressSanitizer", "Miri"
# Quicker to build; the tests are small.
QUICKLY = [word for name in ("eos", "impact", "md", "kit") for word in ("--config", f"profile.dev.package.hvi-{name}.opt-level=1")]
# What checks, what is unsafe there, and the tests.
CHECKS = [
    (ADDRESS, "eight numbers side by side, of all stages: `stages/kit/src/lanes`", ["-p", "hvi-kit", "--lib", "lanes"]),
    (ADDRESS, "forces between atoms: `stages/md/src/lanes`", ["-p", "hvi-md", "--test", "kernel"]),
    (ADDRESS, "particles and grid: `stages/impact/src`", ["-p", "hvi-impact", "--test", "lanes"]),
    (MIRI, "a grid that is added to: `stages/impact/src/grid.rs`", ["-p", "hvi-impact", "--lib", "grid::"]),
]


def checked(check, arguments, folder):
    """Tests that passed, whether there was a finding, and how long it took."""
    environment = {**os.environ, "CARGO_TARGET_DIR": str(folder / check), "CARGO_INCREMENTAL": "0"}
    command = ["cargo", "+nightly"]
    if check == MIRI:
        command += ["miri", "test", *arguments]
        environment["MIRIFLAGS"] = "-Zmiri-disable-isolation"
    else:
        environment["RUSTFLAGS"] = "-Zsanitizer=address"
        command += ["test", "--target", TARGET, *QUICKLY, *arguments]
    start = time.monotonic()
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, errors="replace")
    passed = sum(int(n) for n in re.findall(r"test result: ok\. (\d+) passed", done.stdout))
    if done.returncode != 0 or not passed:
        print(done.stdout[-3000:], done.stderr[-3000:], file=sys.stderr)
    return passed, int(done.returncode != 0 or not passed), time.monotonic() - start


def main():
    parser = arguments(__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "target/sanitize", help="where it is built")
    parser.add_argument("--only", nargs="*", help="the first words of rows: a check, or what is unsafe")
    args = parser.parse_args()
    found = {}
    for check, what, tests in CHECKS:
        if args.only is None or any(f"{check} {what}".startswith(word) for word in args.only):
            passed, findings, seconds = checked(check, tests, args.folder)
            found[check, what] = [str(passed), str(findings)]
            print(check, what, passed, findings, f"{seconds:.0f} s", file=sys.stderr, flush=True)
            write(args.write, found)
    sys.exit(1 if any(row[1] != "0" for row in found.values()) else 0)


def known(page):
    """Rows that the page has from earlier runs: what isn't asked for stays."""
    for line in page.read_text().splitlines() if page and page.exists() else []:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[0] in (ADDRESS, MIRI) and len(cells) == 4:
            yield (cells[0], cells[1]), cells[2:]


def write(page, found):
    found = {**dict(known(page)), **found}
    rows = [[check, what, *found[check, what]] for check, what, _ in CHECKS if (check, what) in found]
    count = sum(len(re.findall(r"\bunsafe\b", p.read_text())) for folder in ("src", "cache/src") for p in (ROOT / folder).rglob("*.rs"))
    text = table(["by", "what is unsafe", "tests", "findings"], rows)
    text += f"\n\n`unsafe` in `src` and `cache`: {count} times. {machine()}\n"
    print(text)
    if page:
        about = __doc__.split("--help\n\n")[1].rsplit("\n\nA nightly", 1)[0]
        write_section(page, "What faults do", "Unsafe parts", f"Made by `make sanitize` (`benches/sanitize.py`).\n\n{about}\n\n{text}")


if __name__ == "__main__":
    main()
