"""Solves Eq. 2 of FDLS on a real take with SciPy and Clarabel beside `match_markers`, and prints CPU times and accuracy.

The page beside this file has the command. All sides run on one thread, in the same run, on the same problems.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[variable] = "1"

import clarabel
import numpy as np
import scipy
from scipy import sparse
from scipy.optimize import lsq_linear

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Frames that the slower sides solve, spread over the take.
FRAMES = 150


def violation(gram, right, weights):
    """How far weights fail the conditions of the optimum, relative to the greatest entry of the right side."""
    slope = gram @ weights - right
    low, high = weights <= 1e-9, weights >= 1 - 1e-9
    wrong = np.where(low, np.maximum(-slope, 0), np.where(high, np.maximum(slope, 0), np.abs(slope)))
    return wrong.max() / np.abs(right).max()


def timed(solve, offsets):
    """Weights of every frame, and CPU seconds a frame."""
    start = time.process_time()
    weights = [solve(offset) for offset in offsets]
    return np.array(weights), (time.process_time() - start) / len(offsets)


def by_clarabel(basis, gram):
    """Clarabel on the quadratic programme, set up once and updated for each frame."""
    size = gram.shape[0]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.presolve_enable = False
    upper = sparse.csc_matrix(np.triu(gram))
    limits = sparse.vstack([sparse.eye(size), -sparse.eye(size)], format="csc")
    bounds = np.concatenate([np.ones(size), np.zeros(size)])
    solver = clarabel.DefaultSolver(upper, np.zeros(size), limits, bounds, [clarabel.NonnegativeConeT(2 * size)], settings)

    def solve(offset):
        solver.update(q=-(basis.T @ offset))
        return np.clip(np.array(solver.solve().x), 0, 1)

    return solve


def main():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="match_markers_"))
    subprocess.run(["cargo", "bench", "-q", "-p", "nodes", "--bench", "match_markers", "--", str(folder)], cwd=ROOT, check=True)
    ours = json.loads((folder / "ours.json").read_text())
    # In millimetres, so that the peers' absolute tolerances stop them where they should.
    basis = 1000 * np.fromfile(folder / "basis.bin").reshape(ours["rows"], ours["channels"])
    offsets = 1000 * np.fromfile(folder / "offsets.bin").reshape(ours["frames"], ours["rows"])
    weights = np.fromfile(folder / "weights.bin", dtype=np.float32).reshape(ours["frames"], ours["channels"])
    gram = basis.T @ basis
    some = np.linspace(0, ours["frames"] - 1, FRAMES).astype(int)

    sides = {
        "SciPy lsq_linear bvls": lambda offset: lsq_linear(basis, offset, (0, 1), method="bvls").x,
        "SciPy lsq_linear trf": lambda offset: lsq_linear(basis, offset, (0, 1), method="trf", tol=1e-10).x,
        "Clarabel, kept and updated": by_clarabel(basis, gram),
    }
    own = ours["cpu_seconds"] / ours["frames"]
    cost = lambda found, frames: 0.5 * np.sum((basis @ found.T - offsets[frames].T) ** 2, axis=0)
    least = cost(weights[some].astype(float), some)
    worst = max(violation(gram, basis.T @ offsets[f], weights[f].astype(float)) for f in some)
    print(f"{ours['rows'] // 3} markers, {ours['channels']} channels; numpy {np.__version__}, scipy {scipy.__version__}, clarabel {clarabel.__version__}")
    print(f"{'match_markers':28} {1 / own:9.0f} frames a CPU second                      KKT {worst:.1e}")
    for name, solve in sides.items():
        found, each = timed(solve, offsets[some])
        worst = max(violation(gram, basis.T @ offsets[f], w) for f, w in zip(some, found))
        above = np.max((cost(found, some) - least) / least)
        print(f"{name:28} {1 / each:9.0f} frames a CPU second, {each / own:7.1f} times ours  KKT {worst:.1e}  cost above ours {above:.1e}")


if __name__ == "__main__":
    sys.exit(main())
