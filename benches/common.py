"""What the scripts of this folder share: a study in a folder of its own, tables in Markdown, pages made of sections."""
import argparse, os, platform, subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

COPPER = 'density = "8930 kg/m3", sound_speed = "3940 m/s", gruneisen = 2.02, heat_capacity = "385 J/kg/K"'
# The cheapest real node: a Mie-Grueneisen equation of state.
METAL = f"""
[step.metal]
use = "eos.handbook"
mie_gruneisen = {{ {COPPER}, slope = 1.5 }}
"""


def sweep(values):
    """The cheapest real nodes, one for each slope in `values`, which is TOML: a list or a range."""
    return f'{METAL}sweep = {{ "mie_gruneisen.slope" = {values} }}\n'


def impact(more, cells=2, width="2 mm", end="0.1 us"):
    """A sphere on a plate, both of `set`."""
    return f"""
[step.set]
use = "eos.handbook"
set = "copper-royce"
[step.hit]
use = "impact"
projectile = {{ shape = "sphere", diameter = "1 mm", material = "copper", eos = "@set" }}
plate = {{ material = "copper", thickness = "0.5 mm", width = "{width}", eos = "@set" }}
cells = {cells}
end = "{end}"
{more}
"""


class Study:
    """A folder with a study and a store."""

    def __init__(self, program, folder, text, name="study"):
        self.program, self.folder, self.name = program, folder, name
        self.store = folder / "store"
        folder.mkdir(parents=True, exist_ok=True)
        self.write(text)

    def write(self, text):
        (self.folder / f"{self.name}.toml").write_text(text)

    def command(self, *more):
        return [str(self.program), "run", f"{self.name}.toml", "--store", str(self.store), *more]

    def start(self, *more):
        return subprocess.Popen(self.command(*more), cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")

    def hvi(self, *arguments):
        """Any command on the store; what came of it."""
        command = [str(self.program), *arguments]
        return subprocess.run(command, cwd=self.folder, env={**os.environ, "HVI_STORE": str(self.store)}, capture_output=True, text=True, errors="replace")

    def files(self, below):
        """Bytes of the files below a folder, hidden ones aside."""
        found = sorted((self.folder / below).rglob("*"))
        return {p: p.read_bytes() for p in found if p.is_file() and p.name[0] != "."}

    def objects(self):
        """Results in the store, by digest."""
        return {p.parent.name + p.name: data for p, data in self.files(self.store / "objects").items()}


def arguments(about):
    """The arguments that all scripts take."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "target/release/hvi-flow"))
    parser.add_argument("--write", type=Path, help="also write what was found to this page")
    return parser


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def machine():
    """What it was measured on."""
    model = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), "?")
    return f"Measured on {os.cpu_count()} cores, {model}, Linux {platform.release()}, load {os.getloadavg()[0]:.1f}."


def write_section(path, title, heading, text):
    """Puts a section into a page in place of the one with its heading, or at the end."""
    old = path.read_text() if path.exists() else ""
    sections = {part.split("\n", 1)[0]: part.split("\n", 1)[1].strip() for part in old.split("\n## ")[1:]}
    sections[heading] = text.strip()
    body = "\n\n".join(f"## {name}\n\n{part}" for name, part in sections.items())
    path.write_text(f"# {title}\n\n{body}\n")
