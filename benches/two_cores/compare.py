"""One thread beside two on a wide graph of real nodes, in turns, each cook with a store that holds the actor and nothing else.

    cargo build --release
    python3 benches/two_cores/compare.py target/release/grimace [--rounds 5]
"""

import argparse
import json
import pathlib
import resource
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).parent


def cook(program, store, *more):
    """Cooks with `store`; gives wall seconds by the program's own clock, CPU seconds, and cells cooked."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "run", HERE / "graph.ron", "--store", store, "--json", *more]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    summary = json.loads(lines[-1])
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return summary["seconds"], cpu, summary["cooked"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("grimace", type=pathlib.Path)
    arguments.add_argument("--rounds", type=int, default=5)
    given = arguments.parse_args()
    program = given.grimace.resolve()
    with tempfile.TemporaryDirectory() as folder:
        actor = pathlib.Path(folder) / "actor"
        cook(program, actor, "--only", "attach")
        best = {}
        for turn in range(given.rounds):
            for jobs in (1, 2):
                store = pathlib.Path(folder) / f"{turn}-{jobs}"
                shutil.copytree(actor, store)
                wall, cpu, cooked = cook(program, store, "--jobs", str(jobs))
                shutil.rmtree(store)
                print(f"{jobs} threads: {wall:.2f} s, {cpu:.2f} s of CPU, {cooked} cooked")
                best[jobs] = min(best.get(jobs, wall), wall)
        print(f"two threads are {best[1] / best[2]:.2f} times as fast (least of {given.rounds} rounds each)")


if __name__ == "__main__":
    main()
