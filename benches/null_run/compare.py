"""A fresh process that finds nothing changed: grimace beside ninja, and beside DVC, Snakemake and Meshroom where they are there.

    python3 benches/null_run/compare.py target/release/grimace [--rounds 5] [--dvc PATH] [--snakemake PATH] \
        [--meshroom CHECKOUT]

Every side gets the same graph: nodes that do next to nothing, in a chain or in layers. Each is brought up to date first; then
the same command runs again, several times, all sides in turn. Printed is the least CPU time (user and system, children
included) and the least wall time of these runs, in milliseconds. DVC, Snakemake and Meshroom get 200 nodes. Meshroom runs by the
Python that runs this, which then needs psutil, requests, markdown and pyseq (`meshroom_side.py`).
"""

import argparse
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time


def shapes():
    return [("chain", 10_000, 1), ("layers of 100", 10_000, 100), ("layers of 100", 100_000, 100), ("chain", 200, 1)]


def before(node, width):
    return None if node < width else node - width


def write_grimace(folder, nodes, width):
    (folder / "take.csv").write_text("frame,jawOpen\n" + "".join(f"{frame},{frame % 3}\n" for frame in range(4)))
    lines = ['"take": (kind: "load_curves", with: (path: "take.csv", rate_hz: 60.0)),']
    for node in range(nodes):
        source = "take" if before(node, width) is None else f"n{before(node, width)}"
        # Parameters of their own, so that no two nodes share a result.
        with_ = f"(filter: gaussian(sigma_frames: {0.5 + node % 1000 / 1000}))"
        lines.append(f'"n{node}": (kind: "smooth_curves", in: {{"curves": "{source}"}}, with: {with_}),')
    (folder / "graph.ron").write_text("(grimace: 1, nodes: {\n" + "\n".join(lines) + "\n})\n")


def write_ninja(folder, nodes, width):
    """For more than 10,000 nodes the outputs are put there, and the rule is a generator's, which needs no log: ninja would take
    ten minutes to make them."""
    given = nodes > 10_000
    lines = ["rule copy", "  command = cp $in $out"] + ["  generator = 1"] * given
    (folder / "take").write_text("0")
    os.utime(folder / "take", (1_000_000_000, 1_000_000_000))
    for node in range(nodes):
        source = "take" if before(node, width) is None else f"n{before(node, width)}"
        lines.append(f"build n{node}: copy {source}")
        if given:
            (folder / f"n{node}").write_text("0")
    (folder / "build.ninja").write_text("\n".join(lines) + "\n")


def write_dvc(folder, nodes, _):
    subprocess.run(["git", "init", "-q"], cwd=folder, check=True)
    (folder / "take").write_text("0")
    lines = ["stages:"]
    for node in range(nodes):
        source = "take" if node == 0 else f"n{node - 1}"
        lines += [f"  s{node}:", f"    cmd: cp {source} n{node}", "    deps:", f"      - {source}", "    outs:", f"      - n{node}"]
    (folder / "dvc.yaml").write_text("\n".join(lines) + "\n")


def write_snakemake(folder, nodes, _):
    (folder / "take").write_text("0")
    rules = [f"rule all:\n    input: 'n{nodes - 1}'\n"]
    for node in range(nodes):
        source = "take" if node == 0 else f"n{node - 1}"
        rules.append(f"rule r{node}:\n    input: '{source}'\n    output: 'n{node}'\n    shell: 'cp {{input}} {{output}}'\n")
    (folder / "Snakefile").write_text("\n".join(rules))


class Side:
    """One program with its graph."""

    def __init__(self, name, command, write, prepare=None):
        self.name, self.command, self.write, self.prepare = name, command, write, prepare

    def make(self, folder, nodes, width):
        self.folder = folder / self.name
        self.folder.mkdir()
        self.write(self.folder, nodes, width)
        for command in self.prepare or []:
            subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
        self.once()

    def once(self):
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        start = time.monotonic()
        subprocess.run(self.command, cwd=self.folder, check=True, capture_output=True)
        wall = time.monotonic() - start
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - usage.ru_utime + after.ru_stime - usage.ru_stime, wall


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grimace", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--ninja", default=shutil.which("ninja"))
    parser.add_argument("--dvc", default=shutil.which("dvc"))
    parser.add_argument("--snakemake", default=shutil.which("snakemake"))
    parser.add_argument("--meshroom", type=pathlib.Path, default=os.environ.get("MESHROOM"))
    arguments = parser.parse_args()
    print(f"{'graph':<14} {'nodes':>8}  {'program':<10} {'CPU ms':>9} {'wall ms':>9}  CPU beside grimace")
    for shape, nodes, width in shapes():
        sides = [Side("grimace", [str(arguments.grimace.resolve()), "run", "graph.ron", "-q"], write_grimace)]
        if arguments.ninja:
            sides.append(Side("ninja", [arguments.ninja, "-j2"], write_ninja))
        if nodes <= 200 and arguments.dvc:
            sides.append(Side("dvc", [arguments.dvc, "repro", "-q"], write_dvc, [[arguments.dvc, "init", "-q"]]))
        if nodes <= 200 and arguments.snakemake:
            sides.append(Side("snakemake", [arguments.snakemake, "-c2", "-q"], write_snakemake))
        if nodes <= 200 and arguments.meshroom:
            os.environ["MESHROOM"] = str(arguments.meshroom)
            script = pathlib.Path(__file__).resolve().with_name("meshroom_side.py")
            sides.append(Side("meshroom", [sys.executable, str(script), str(nodes)], lambda *_: None))
        with tempfile.TemporaryDirectory() as folder:
            for side in sides:
                side.make(pathlib.Path(folder), nodes, width)
            # Files younger than a file system's clock may change unseen; grimace reads those again.
            time.sleep(2.1)
            for side in sides:
                side.once()
            rounds = [[side.once() for side in sides] for _ in range(arguments.rounds)]
        for place, side in enumerate(sides):
            cpu = min(row[place][0] for row in rounds) * 1e3
            wall = min(row[place][1] for row in rounds) * 1e3
            own = min(row[0][0] for row in rounds) * 1e3
            print(f"{shape:<14} {nodes:>8}  {side.name:<10} {cpu:>9.1f} {wall:>9.1f}  {cpu / own:>8.1f} x", flush=True)


if __name__ == "__main__":
    main()
