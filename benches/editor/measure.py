"""The editor in a terminal of tmux, as a hand meets it: what it writes with `--timings` while keys are pressed.

    cargo build --release
    python3 benches/editor/measure.py target/release/grimace [--data ../shared/data] [--rounds 40]

- `curves`: from the key that moves a key of a take's curves to the screen with the curves cooked anew, on `graphs/fdls_ict` with
  one take of the test data (left out where there is none); networks are trained for two epochs first.
- `keys`: from a key to the screen that shows it, on a graph of 1,000 nodes while all of them cook.
- `open`: from the start of the editor to its first screen, on a graph of 10,000 nodes; and from the start of the process until
  tmux has that screen.
"""

import argparse
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).parent.parent.parent


class Pane:
    """A terminal with the editor in it."""

    def __init__(self, command, size=(120, 40)):
        self.server = f"grimace-bench-{time.monotonic_ns()}"
        line = "exec " + " ".join(f"'{part}'" for part in command)
        self.tmux("-f", "/dev/null", "new-session", "-d", "-x", str(size[0]), "-y", str(size[1]), line)

    def tmux(self, *arguments):
        done = subprocess.run(["tmux", "-L", self.server, *arguments], capture_output=True, text=True)
        return done.stdout

    def press(self, *keys, pause=0.05):
        for key in keys:
            self.tmux("send-keys", key)
            time.sleep(pause)

    def screen(self):
        return self.tmux("capture-pane", "-p")

    def wait(self, holds, seconds=300.0):
        begun = time.monotonic()
        while not holds(self.screen()):
            if time.monotonic() - begun > seconds:
                raise SystemExit(f"it does not come:\n{self.screen()}")
            time.sleep(0.005)

    def leave(self):
        self.press("q", "d")
        time.sleep(0.5)
        self.tmux("kill-server")


def times(file, what):
    lines = [line.split() for line in file.read_text().splitlines()]
    return sorted(float(taken) for name, taken in lines if name == what)


def told(name, taken):
    share = lambda part: taken[min(len(taken) - 1, int(part * len(taken)))]
    print(f"{name}: median {statistics.median(taken):.1f} ms, 95% within {share(0.95):.1f} ms, "
          f"most {taken[-1]:.1f} ms, of {len(taken)}", flush=True)


def graph_of(count, frames):
    """Curves of a sample take, smoothed again and again: layers of 100 nodes, each on one of the layer before."""
    lines = [f'"actor": (kind: "sample_actor", with: (takes: 1, frames: {frames}, density: 0.5, rom_frames: 600)),']
    for at in range(count - 1):
        layer, place = divmod(at, 100)
        source = "actor.truth" if layer == 0 else f"n{layer - 1:03}_{(place * 7 + layer) % 100:02}"
        lines.append(f'"n{layer:03}_{place:02}": (kind: "smooth_curves", in: {{"curves": "{source}"}}, '
                     f'with: (filter: gaussian(sigma_frames: {2 + at % 17}.5))),')
    body = "\n        ".join(lines)
    return f"(\n    grimace: 1,\n    nodes: {{\n        {body}\n    }},\n)\n"


def measure_curves(grimace, data, folder, rounds):
    actor = data / "actors/ict_actor_a"
    if not actor.is_dir():
        print(f"SKIPPED: curves: there is no test data in {data}")
        return
    for graph in ["fdls", "fdls_ict"]:
        shutil.copytree(ROOT / "graphs" / graph, folder / graph, ignore=shutil.ignore_patterns(".grimace", "out", "golden"))
    sets = [f"actor={actor}/ict_actor_a.glb", f"neutral_markers={actor}/neutral_markers.csv", "epochs=2",
            f"regions={data}/actors/regions.json", f"rom={actor}/rom/*.csv", f"takes={actor}/takes/day1_161.c3d"]
    timings = folder / "curves.txt"
    command = [grimace, "edit", folder / "fdls_ict", "--store", folder / "store", "--out", folder / "out",
               "--timings", timings]
    command += [part for one in sets for part in ("--set", one)]
    for channel, name in [("browDown_L", "a key on the brow"), ("jawOpen", "a key on the jaw, which other regions follow")]:
        pane = Pane(command)
        pane.wait(lambda shown: "nodes" in shown)
        pane.press("/", *"solve", "Enter", "v")
        pane.wait(lambda shown: "mm off by region" in shown)
        fresh = lambda shown: "newer than the curves" not in shown and "cooking" not in shown
        pane.press("/", *channel, "Enter", *["L"] * 50)
        pane.press("+")
        pane.wait(fresh)
        for at in range(rounds):
            pane.press(">", pause=0.02)
            pane.wait(fresh)
            time.sleep(0.1)
        pane.leave()
        told(f"{name}, moved by a frame, 1,846 frames", times(timings, "curves"))


def measure_keys(grimace, folder):
    graph, timings = folder / "thousand.ron", folder / "keys.txt"
    graph.write_text(graph_of(1000, 12000))
    pane = Pane([grimace, "edit", graph, "--store", folder / "thousand", "--timings", timings])
    pane.wait(lambda shown: "1000 nodes" in shown)
    pane.press("r", pause=1.0)
    pane.wait(lambda shown: "cooking" in shown)
    pressed = ["l", "j", "j", "l", "k", "l", ".", ",", "h", "L", "J", "H", "K", "c", "z", "z", "tab", "tab", "/", "n", "5", "Enter", "p", "p"]
    pressed = ["Tab" if key == "tab" else key for key in pressed]
    for _ in range(15):
        pane.press(*pressed, pause=0.01)
    cooks = "cooking" in pane.screen()
    pane.press("Escape", pause=0.5)
    pane.press("x")
    pane.wait(lambda shown: "cooking" not in shown and "ending" not in shown)
    pane.leave()
    told(f"a key at 1,000 nodes, {'while all cook' if cooks else 'THE COOK ENDED TOO SOON'}", times(timings, "key"))


def measure_open(grimace, folder):
    graph, timings = folder / "ten_thousand.ron", folder / "open.txt"
    graph.write_text(graph_of(10000, 60))
    first, seen = [], []
    for _ in range(5):
        begun = time.monotonic()
        pane = Pane([grimace, "edit", graph, "--store", folder / "ten", "--timings", timings])
        pane.wait(lambda shown: "10000 nodes" in shown)
        seen.append(1e3 * (time.monotonic() - begun))
        pane.leave()
        first += times(timings, "open")
    told("10,000 nodes to the first screen", sorted(first))
    told("the same from the start of tmux until it has the screen", sorted(seen))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("grimace", type=pathlib.Path)
    arguments.add_argument("--data", type=pathlib.Path, default=ROOT / "../shared/data")
    arguments.add_argument("--rounds", type=int, default=40)
    given = arguments.parse_args()
    grimace = given.grimace.resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        measure_curves(grimace, given.data.resolve(), folder, given.rounds)
        measure_keys(grimace, folder)
        measure_open(grimace, folder)


if __name__ == "__main__":
    main()
