"""From a complete take to its curves: `grimace watch`, which stays, beside a plain `grimace run` of the same take.

    python3 benches/watch/compare.py target/release/grimace [--takes 7] [--frames 600]

Takes of the sample actor are written as C3D files; the networks of `graphs/fdls` are trained first, in a store for each side.
Then take after take is renamed into both folders, and the sides take turns. A watch is timed from the rename to the event that
tells that the curves are in their place, a run from its start to its end. Printed are the median and the least, in milliseconds.
"""

import argparse
import json
import os
import pathlib
import queue
import shutil
import statistics
import subprocess
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]

TAKES = """(grimace: 1, nodes: {
    "actor": (kind: "sample_actor", with: (takes: COUNT, frames: FRAMES)),
    "save": (kind: "save_markers", in: {"markers": "actor.takes"}, with: (path: "made/{take}.c3d")),
})
"""

GRAPH = """#![enable(implicit_some)]
(grimace: 1, nodes: {
    "actor": (kind: "sample_actor", with: (takes: 1, frames: FRAMES)),
    "takes": (kind: "load_markers", with: (path: "takes/*.c3d")),
    "rig": (kind: "skin_jaw", in: {"rig": "actor.rig"}),
    "attach": (kind: "attach_markers", in: {"rig": "rig", "neutral": "actor.neutral"}),
    "noise": (kind: "measure_jitter", in: {"markers": "actor.takes"}),
    "train": (
        graph: "fdls/train.ron",
        in: {
            "rig": "rig", "attachment": "attach", "neutral": "actor.neutral", "regions": "actor.regions",
            "rom": "actor.rom", "noise": "noise",
        },
        with: (epochs: 2),
    ),
    "solve": (
        for_each: "takes",
        graph: "fdls/solve_take.ron",
        in: {
            "rig": "rig", "attachment": "attach", "neutral": "actor.neutral", "regions": "actor.regions",
            "networks": "train.networks",
        },
    ),
    "save": (kind: "save_curves", in: {"curves": "solve.curves"}, with: (path: "out/{take}.csv")),
})
"""


class Side:
    """A folder with the graph, trained and with one take solved."""

    def __init__(self, program, folder, frames, first):
        self.program, self.folder = program, folder
        (folder / "takes").mkdir(parents=True)
        shutil.copytree(ROOT / "graphs/fdls", folder / "fdls")
        (folder / "graph.ron").write_text(GRAPH.replace("FRAMES", str(frames)))
        self.take(first)
        self.run()

    def command(self, *arguments):
        return [self.program, *arguments, "--store", str(self.folder / "store")]

    def take(self, file):
        part = self.folder / "part"
        shutil.copyfile(file, part)
        os.rename(part, self.folder / "takes" / file.name)

    def run(self):
        begin = time.perf_counter()
        subprocess.run(self.command("run", "graph.ron", "--quiet"), cwd=self.folder, check=True)
        return time.perf_counter() - begin


class Watch:
    """A watch, and the lines that it says with the moments at which it said them."""

    def __init__(self, side):
        self.side, self.said = side, queue.Queue()
        command = side.command("watch", "graph.ron", "--json")
        self.process = subprocess.Popen(command, cwd=side.folder, stdout=subprocess.PIPE, text=True)
        threading.Thread(target=self.listen, daemon=True).start()
        self.until("waiting")

    def listen(self):
        for line in self.process.stdout:
            self.said.put((time.perf_counter(), json.loads(line)))

    def until(self, event):
        while True:
            at, said = self.said.get(timeout=300)
            if said["event"] == event:
                return at, said

    def take(self, file):
        begin = time.perf_counter()
        self.side.take(file)
        at, said = self.until("wrote")
        if said["node"] != f"save@{file.stem}":
            raise SystemExit(f"{said} instead of {file.stem}")
        self.until("waiting")
        return at - begin

    def end(self):
        self.process.terminate()
        self.process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--takes", type=int, default=7)
    parser.add_argument("--frames", type=int, default=600)
    asked = parser.parse_args()
    program = str(pathlib.Path(asked.program).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        graph = TAKES.replace("COUNT", str(asked.takes + 1)).replace("FRAMES", str(asked.frames))
        (folder / "takes.ron").write_text(graph)
        store = str(folder / "store")
        subprocess.run([program, "run", "takes.ron", "--quiet", "--store", store], cwd=folder, check=True)
        first, *takes = sorted((folder / "made").glob("*.c3d"))
        watch = Watch(Side(program, folder / "watched", asked.frames, first))
        plain = Side(program, folder / "run", asked.frames, first)
        seconds = {"watch": [], "run": []}
        for take in takes:
            seconds["watch"].append(watch.take(take))
            plain.take(take)
            seconds["run"].append(plain.run())
        watch.end()
        for take in takes:
            watched, run = (folder / side / "out" / f"{take.stem}.csv" for side in ("watched", "run"))
            if watched.read_bytes() != run.read_bytes():
                raise SystemExit(f"{take.stem} differs")
        for side, all_s in seconds.items():
            print(f"{side:6} median {statistics.median(all_s) * 1e3:7.0f} ms, least {min(all_s) * 1e3:7.0f} ms")


main()
