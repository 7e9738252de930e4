"""Fine-tunes frames of a real take with SciPy's L-BFGS-B beside `finetune_curves`: the same objective, its gradient by hand.

The page beside this file has the command. Both sides have two threads (here two processes); ours runs before and after.
"""

import json
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import time

THREADS = 2
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["RAYON_NUM_THREADS"] = str(THREADS)

import numpy as np
import scipy
from scipy.optimize import minimize

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Frames that the slower side solves, spread over the take.
FRAMES = 120


def ours(folder):
    command = ["cargo", "bench", "-q", "-p", "nodes", "--bench", "finetune", "--", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True)
    return json.loads((folder / "ours.json").read_text())


def turn(axis, angle):
    """The rotation about an axis, and its derivative by the angle."""
    c, s, a, b = np.cos(angle), np.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    rotation, slope = np.zeros((3, 3)), np.zeros((3, 3))
    rotation[axis, axis] = 1
    rotation[a, a], rotation[a, b], rotation[b, a], rotation[b, b] = c, -s, s, c
    slope[a, a], slope[a, b], slope[b, a], slope[b, b] = -s, -c, c, -s
    return rotation, slope


class Puppet:
    """The markers at channel weights, and what forces on them mean for the channels."""

    def __init__(self, folder, told):
        read = lambda name: np.fromfile(folder / name)
        markers, drivers = told["markers"], told["drivers"]
        self.rest = np.concatenate([read("rest_jaw.bin"), read("rest_skull.bin")])
        shapes = [read(f"shapes_{part}.bin").reshape(len(drivers), 3 * markers) for part in ("jaw", "skull")]
        self.motions = np.concatenate([read("euler.bin").reshape(-1, 3), read("shift.bin").reshape(-1, 3)], 1)
        self.shapes = np.ascontiguousarray(np.concatenate(shapes, 1))
        self.shares, self.pivot = read("shares.bin"), np.array(told["pivot_m"])
        self.follows = self.shares[:, None] * self.pivot
        # Products of channels, padded with a channel that is always 1; then tents.
        self.products = np.array([k for k, driver in enumerate(drivers) if "product" in driver])
        width = max(len(drivers[k]["product"]) for k in self.products)
        one = told["channels"]
        self.factors = np.array([drivers[k]["product"] + [one] * (width - len(drivers[k]["product"])) for k in self.products])
        self.tents = np.array([k for k, driver in enumerate(drivers) if "tent" in driver], dtype=int)
        self.tent_channels = np.array([drivers[k]["channel"] for k in self.tents], dtype=int)
        self.below, self.peak, self.above = np.array([drivers[k]["tent"] for k in self.tents]).reshape(-1, 3).T
        self.count, self.markers, self.size = len(drivers), markers, one

    def at(self, w):
        full = np.append(w, 1.0)
        own = full[self.factors]
        weights = np.empty(self.count)
        weights[self.products] = own.prod(1)
        height = w[self.tent_channels]
        rising, falling = (height - self.below) / (self.peak - self.below), (self.above - height) / (self.above - self.peak)
        weights[self.tents] = np.maximum(np.minimum(rising, falling), 0)
        parts = (self.rest + weights @ self.shapes).reshape(2, self.markers, 3)
        motion = weights @ self.motions
        (x, dx), (y, dy), (z, dz) = (turn(axis, motion[axis]) for axis in range(3))
        rotation = z @ y @ x
        moved = self.pivot - rotation @ self.pivot + motion[3:]
        positions = parts[0] @ rotation.T + parts[1] + self.shares[:, None] * moved
        return positions, (own, height, parts[0], rotation, (z @ y @ dx, z @ dy @ x, dz @ y @ x))

    def back(self, kept, forces):
        own, height, follower, rotation, turns = kept
        by_shape = self.shapes @ np.concatenate([(forces @ rotation).ravel(), forces.ravel()])
        moment = forces.T @ (follower - self.follows)
        turning = [np.sum(moment * slope) for slope in turns]
        by_shape += self.motions @ np.concatenate([turning, self.shares @ forces])
        by_channel = np.zeros(self.size + 1)
        of_products = by_shape[self.products]
        for place in range(own.shape[1]):
            others = np.delete(own, place, 1).prod(1)
            by_channel += np.bincount(self.factors[:, place], of_products * others, self.size + 1)
        slope = np.where((height >= self.below) & (height < self.peak), 1 / (self.peak - self.below), 0)
        slope = np.where((height >= self.peak) & (height < self.above), -1 / (self.above - self.peak), slope)
        return by_channel[:-1] + np.bincount(self.tent_channels, by_shape[self.tents] * slope, self.size)


class Problem:
    def __init__(self, folder, told):
        self.puppet = Puppet(folder, told)
        self.raw = np.fromfile(folder / "raw.bin").reshape(told["frames"], -1)
        self.take = np.fromfile(folder / "take.bin").reshape(told["frames"], -1, 3)
        self.trust, self.hold = told["noise_m"] ** -2, told["raw_error"] ** -2

    def value(self, w, frame):
        positions, kept = self.puppet.at(w)
        apart = positions - self.take[frame]
        apart[~np.isfinite(apart[:, 0])] = 0
        shift = w - self.raw[frame]
        value = self.trust * np.vdot(apart, apart) + self.hold * (shift @ shift)
        return value, self.puppet.back(kept, 2 * self.trust * apart) + 2 * self.hold * shift


SETTINGS = {
    "as it comes": {},
    "finer": {"ftol": 1e-12, "gtol": 1e-4, "maxiter": 2000, "maxfun": 4000, "maxcor": 30},
}
problem = None


def solve(job):
    frame, options = job
    size = problem.raw.shape[1]
    found = minimize(problem.value, problem.raw[frame], (frame,), "L-BFGS-B", jac=True, bounds=[(0, 1)] * size, options=options)
    return found.x, found.fun, found.nfev


def main():
    global problem
    folder = pathlib.Path(tempfile.mkdtemp(prefix="finetune_"))
    told = ours(folder)
    problem = Problem(folder, told)
    tuned = np.fromfile(folder / "tuned.bin").reshape(problem.raw.shape)
    posed = np.fromfile(folder / "posed.bin").reshape(problem.take.shape)
    some = np.linspace(0, told["frames"] - 1, FRAMES).astype(int)

    # The two puppets are the same, and the gradient is that of the value.
    apart = max(np.abs(problem.puppet.at(tuned[f])[0] - posed[f]).max() for f in some)
    rng = np.random.default_rng(1)
    w, step = rng.uniform(0.1, 0.9, problem.raw.shape[1]), 1e-6
    slope = problem.value(w, some[0])[1]
    measured = [(problem.value(w + step * unit, some[0])[0] - problem.value(w - step * unit, some[0])[0]) / (2 * step) for unit in np.eye(len(w))]
    print(f"{told['markers']} markers, {told['channels']} channels, {told['frames']} frames; numpy {np.__version__}, scipy {scipy.__version__}")
    print(f"puppets within {apart * 1e6:.2f} um, gradient within {np.abs(slope - measured).max() / np.abs(slope).max():.1e} of differences")

    least = np.array([problem.value(tuned[f], f)[0] for f in some])
    residual = lambda answers: 1e3 * np.mean([np.nanmean(np.linalg.norm(problem.puppet.at(w)[0] - problem.take[f], axis=1)) for w, f in zip(answers, some)])
    rows = []
    with multiprocessing.get_context("fork").Pool(THREADS) as pool:
        for name, options in SETTINGS.items():
            pool.map(solve, [(f, options) for f in some[:4]])
            begin = time.perf_counter()
            answers = pool.map(solve, [(f, options) for f in some], chunksize=2)
            rows.append((name, FRAMES / (time.perf_counter() - begin), answers))
    again = ours(folder)
    rates = [run["frames"] / run["seconds"] for run in (told, again)]
    print(f"finetune_curves: {rates[0]:.0f} and {rates[1]:.0f} frames a second, {told['steps'] / told['frames']:.1f} steps a frame, {told['unfinished']} unfinished, objective {least.mean():.4f} in the mean, markers {residual(tuned[some]):.5f} mm off")
    for name, rate, answers in rows:
        cost = np.array([fun for _, fun, _ in answers])
        found = [x for x, _, _ in answers]
        above = cost / least - 1
        print(f"SciPy L-BFGS-B {name}: {rate:.1f} frames a second, ours {min(rates) / rate:.0f} to {max(rates) / rate:.0f} times as many; {np.mean([n for _, _, n in answers]):.0f} evaluations a frame, objective {cost.mean():.4f}, markers {residual(found):.5f} mm off; objective above ours by {above.min():.1e} to {above.max():.1e} (middle {np.median(above):.1e}), weights within {np.abs(np.array(found) - tuned[some]).max():.1e}")


if __name__ == "__main__":
    sys.exit(main())
