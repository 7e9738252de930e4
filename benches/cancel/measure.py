"""From a ctrl-C to the end of the process, while the networks of `graphs/fdls` train.

    cargo build --release
    python3 benches/cancel/measure.py target/release/grimace [--times 20]
"""

import argparse
import json
import pathlib
import random
import signal
import subprocess
import tempfile
import time

GRAPH = pathlib.Path(__file__).parent.parent.parent / "graphs/fdls"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("grimace", type=pathlib.Path)
    arguments.add_argument("--times", type=int, default=20)
    given = arguments.parse_args()
    chance = random.Random(1)
    took = []
    with tempfile.TemporaryDirectory() as folder:
        command = [given.grimace.resolve(), "run", GRAPH, "--json", "--set", "epochs=2000"]
        command += ["--store", f"{folder}/store", "--out", f"{folder}/out"]
        for _ in range(given.times):
            child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
            for line in child.stdout:
                event = json.loads(line)
                if event["event"] == "progress" and event["node"] == "train/train":
                    break
            time.sleep(chance.uniform(0.0, 1.0))
            start = time.monotonic()
            child.send_signal(signal.SIGINT)
            last = json.loads(child.stdout.read().splitlines()[-1])
            told = time.monotonic() - start
            assert child.wait() == 130 and last["cancelled"], last
            took.append(time.monotonic() - start)
            print(f"told after {1e3 * told:.0f} ms, ended after {1e3 * took[-1]:.0f} ms", flush=True)
    took.sort()
    print(f"median {1e3 * took[len(took) // 2]:.0f} ms, longest {1e3 * took[-1]:.0f} ms of {given.times}")


if __name__ == "__main__":
    main()
