"""Runs the networks that the benchmark `networks` wrote with NumPy and PyTorch, and prints both sides' times and answers.

The page beside this file has the command. Both sides have two threads; ours runs before and after the other.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

THREADS = 2
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[variable] = str(THREADS)
# Waiting threads sleep. Spinning, which is the usual, is a little faster on an idle machine and far slower on a busy one.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import numpy as np
import torch
from torch import nn

torch.set_num_threads(THREADS)
ROOT = pathlib.Path(__file__).resolve().parents[2]
MODES = sys.argv[1:] or ["eager", "compiled"]


def ours(folder):
    command = ["cargo", "bench", "-q", "-p", "nodes", "--bench", "networks", "--", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True)
    return json.loads((folder / "ours.json").read_text())


class Network(nn.Module):
    """Section 8 and Fig. 4 of the FDLS supplement, as `learn::Architecture` has it."""

    def __init__(self, shape):
        super().__init__()
        width = shape["width"]
        self.enter = nn.Linear(shape["inputs"], width)
        self.open = nn.ModuleList(nn.Linear(width, width) for _ in range(shape["blocks"]))
        self.close = nn.ModuleList(nn.Linear(width, width) for _ in range(shape["blocks"]))
        self.head = nn.Linear(width + shape["conditions"], width)
        self.leave = nn.Linear(width, shape["outputs"])
        self.conditioned = shape["conditions"] > 0
        # A dropout of 0 is left out, as a user would.
        self.drop = nn.Dropout(shape["dropout"]) if shape["dropout"] else nn.Identity()

    def forward(self, inputs, conditions):
        hidden = self.enter(inputs).relu_()
        for opening, closing in zip(self.open, self.close):
            hidden = (hidden + closing(self.drop(opening(hidden).relu_()))).relu_()
        if self.conditioned:
            hidden = torch.cat([hidden, conditions], 1)
        return self.leave(self.head(hidden).relu_())

    def begin(self):
        """First weights as ours: even, of variance g / inputs, with g = 2, 2 / blocks where a block closes, 1 for the outputs."""
        gains = [2.0, *[2.0, 2.0 / max(len(self.close), 1)] * len(self.close), 2.0, 1.0]
        for layer, gain in zip(self.layers(), gains):
            limit = (3 * gain / layer.in_features) ** 0.5
            nn.init.uniform_(layer.weight, -limit, limit)
            nn.init.zeros_(layer.bias)
        return self

    def layers(self):
        blocks = [layer for pair in zip(self.open, self.close) for layer in pair]
        return [self.enter, *blocks, self.head, self.leave]


def read(shape, numbers):
    """Means and scales of the three tables and the network, from the front of `numbers`; and what is left."""
    scalings = []
    for size in (shape["inputs"], shape["conditions"], shape["outputs"]):
        scalings.append((numbers[:size], numbers[size : 2 * size]))
        numbers = numbers[2 * size :]
    network = Network(shape)
    with torch.no_grad():
        for layer in network.layers():
            rows, columns = layer.in_features, layer.out_features
            layer.weight.copy_(torch.from_numpy(numbers[: rows * columns].reshape(rows, columns).T.copy()))
            numbers = numbers[rows * columns :]
            layer.bias.copy_(torch.from_numpy(numbers[:columns].copy()))
            numbers = numbers[columns:]
    return scalings, network, numbers


class Region:
    def __init__(self, told, scalings, network):
        self.told, self.scalings, self.network = told, scalings, network
        self.markers = np.array(told["markers"])
        self.first, self.second = np.triu_indices(len(self.markers), 1)

    def features(self, markers, neutral):
        """One row a frame, by NumPy."""
        points = np.ascontiguousarray(markers[:, self.markers])
        sets = self.told["sets"]
        if "distance" in sets or "direction" in sets:
            apart = points[:, self.first] - points[:, self.second]
            distance = np.sqrt(np.einsum("fpc,fpc->fp", apart, apart))
        made = []
        for name in sets:
            if name == "distance":
                made.append(distance)
            elif name == "direction":
                made.append((apart / distance[:, :, None]).reshape(len(points), -1))
            elif name == "delta":
                made.append((points - neutral[self.markers]).reshape(len(points), -1))
        return np.concatenate(made, 1) if len(made) > 1 else made[0]

    def standardised(self, table, values):
        mean, scale = self.scalings[table]
        return torch.from_numpy((values - mean) / scale)

    def samples(self, markers, neutral, curves):
        inputs = self.standardised(0, self.features(markers, neutral))
        conditions = self.standardised(1, np.ascontiguousarray(curves[:, self.told["conditions"]]))
        return inputs, conditions, self.standardised(2, np.ascontiguousarray(curves[:, self.told["channels"]]))


def trainer(network, rate, mode):
    """A function that makes one step and gives the loss."""
    run = torch.compile(network) if mode == "compiled" else network
    adam = torch.optim.Adam(network.parameters(), lr=rate, weight_decay=1e-5, fused=True)

    def step(inputs, conditions, targets):
        loss = nn.functional.mse_loss(run(inputs, conditions), targets)
        loss.backward()
        adam.step()
        adam.zero_grad(set_to_none=True)
        return loss.detach()

    return step


def epoch(step, samples, batch=64):
    """One pass in random order; the mean loss."""
    rows = len(samples[0])
    losses = 0.0
    for chosen in torch.randperm(rows).split(batch):
        losses += step(*(table[chosen] for table in samples)) * len(chosen)
    return float(losses) / rows


def lower_face_steps(region, samples, told, mode, threads=THREADS):
    """Seconds a step: the least and the middle epoch."""
    torch.set_num_threads(threads)
    batches, epochs = told["steps"]
    network = Network(region.told["architecture"]).begin()
    step = trainer(network, 1e-4, mode)
    cut = [table[: 64 * batches].contiguous() for table in samples]
    times = []
    for _ in range(epochs):
        begin = time.perf_counter()
        epoch(step, cut)
        times.append((time.perf_counter() - begin) / batches)
    torch.set_num_threads(THREADS)
    times = sorted(times[1:])
    return times[0], times[len(times) // 2]


# Peak step sizes of the supplement's tables.
RATES = {"upper-face": 5e-4, "eyelids": 2e-4}


def train_seven(regions, samples, epochs, mode, side_by_side):
    """Seconds of all networks, and each one's last loss. Compiling is not counted."""
    steps = []
    for region, own in zip(regions, samples):
        step = trainer(Network(region.told["architecture"]).begin(), RATES.get(region.told["region"], 1e-4), mode)
        if mode == "compiled":
            # Both sizes that an epoch has: whole batches and what is left.
            for rows in (64, len(own[0]) % 64 or 64):
                step(*(table[:rows] for table in own))
        steps.append(step)

    def run(index):
        torch.set_num_threads(1 if side_by_side else THREADS)
        return index, [epoch(steps[index], samples[index]) for _ in range(epochs)][-1]

    order = sorted(range(len(regions)), key=lambda index: -regions[index].told["parameters"])
    begin = time.perf_counter()
    if side_by_side:
        with ThreadPoolExecutor(THREADS) as pool:
            done = dict(pool.map(run, order))
    else:
        done = dict(map(run, order))
    seconds = time.perf_counter() - begin
    torch.set_num_threads(THREADS)
    return seconds, [done[index] for index in range(len(regions))]


def solver(regions, told, take, neutral, mode):
    """A function that gives the weights of all frames: features, the jaw, then all other regions on top of it."""
    jaw = next(region for region in regions if region.told["region"] == told["jaw"])
    run = {id(region): torch.compile(region.network) if mode == "compiled" else region.network for region in regions}
    # Standardisation is folded into one product and one sum, made once.
    scaled = {id(region): [(torch.from_numpy(1 / s), torch.from_numpy(-m / s)) for m, s in region.scalings] for region in regions}
    for region in regions:
        region.network.eval()

    @torch.inference_mode()
    def solve():
        weights = torch.zeros(len(take), len(told["channels"]))
        for region in [jaw, *(region for region in regions if region is not jaw)]:
            (slope, shift), (condition_slope, condition_shift), _ = scaled[id(region)]
            inputs = torch.from_numpy(region.features(take, neutral)).mul_(slope).add_(shift)
            conditions = weights[:, region.told["conditions"]] * condition_slope + condition_shift
            mean, scale = (torch.from_numpy(part) for part in region.scalings[2])
            found = run[id(region)](inputs, conditions) * scale + mean
            weights[:, region.told["channels"]] = found.clamp_(0, 1)
        return weights

    return solve


def halves(solve_of, take):
    """The same with half of the take on each of two threads."""
    cut = [solve_of(part) for part in np.array_split(take, THREADS)]
    pool = ThreadPoolExecutor(THREADS, initializer=torch.set_num_threads, initargs=(1,))
    return lambda: torch.cat(list(pool.map(lambda solve: solve(), cut)))


def timed(what, rounds):
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        what()
        times.append(time.perf_counter() - begin)
    times.sort()
    return times[0], times[len(times) // 2]


def main():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="networks_"))
    told = ours(folder)
    read32 = lambda name: np.fromfile(folder / name, dtype="<f4")
    points = lambda name: read32(name).reshape(-1, told["markers"], 3)
    neutral, motion, take = points("neutral.bin")[0], points("motion.bin"), points("take.bin")
    curves = read32("curves.bin").reshape(len(motion), -1)
    numbers, regions = read32("networks.bin"), []
    for own in told["networks"]:
        scalings, network, numbers = read(own["architecture"], numbers)
        regions.append(Region(own, scalings, network))
    samples = [region.samples(motion, neutral, curves) for region in regions]
    lower = next(index for index, region in enumerate(regions) if region.told["region"] == "lower-face")

    print(f"torch {torch.__version__}, numpy {np.__version__}; {told['motion_frames']} frames to train on, {told['take_frames']} to solve")
    for region in regions:
        shape = region.told["architecture"]
        print(f"  {region.told['region']}: {shape['inputs']} inputs, width {shape['width']}, {shape['blocks']} blocks, {shape['conditions']} conditions, {shape['outputs']} channels, {region.told['parameters']} parameters")

    # Steps from the same start on the same batch.
    shape = {**regions[lower].told["architecture"], "dropout": 0.0}
    scalings, network, _ = read(shape, read32("start.bin"))
    one = Region(regions[lower].told, scalings, network)
    batch = one.samples(motion[:64], neutral, curves[:64])
    step = trainer(network, 1e-4, "eager")
    losses = np.array([float(step(*batch)) for _ in told["losses_from_start"]])
    off = np.abs(losses / np.array(told["losses_from_start"]) - 1)
    print(f"{len(losses)} steps from one start on one batch: loss {losses[0]:.5f} to {losses[-1]:.5f}, both sides within {off[:5].max():.1e} of each other over five steps, {off.max():.1e} over all")

    theirs = {"step": {}, "train": {}, "solve": {}}
    for mode in MODES:
        theirs["step"][mode] = lower_face_steps(regions[lower], samples[lower], told, mode)[1]
        theirs["step"][f"{mode}, one thread"] = lower_face_steps(regions[lower], samples[lower], told, mode, 1)[1]
        theirs["train"][f"{mode}, one after the other"], lost = train_seven(regions, samples, told["epochs"], mode, False)
        if mode == "eager":
            # Compiled functions of several threads trip over each other's caches.
            theirs["train"][f"{mode}, two side by side"], lost = train_seven(regions, samples, told["epochs"], mode, True)
        solve = solver(regions, told, take, neutral, mode)
        found = solve().numpy()
        theirs["solve"][mode] = timed(solve, 15)[1]
        if mode == "eager":
            side = halves(lambda part: solver(regions, told, part, neutral, mode), take)
            side()
            theirs["solve"][f"{mode}, two side by side"] = timed(side, 15)[1]
        off = np.abs(found - read32("solved.bin").reshape(found.shape)).max()
        print(f"{mode}: weights of the take differ by at most {off:.1e}; last losses " + ", ".join(f"{region.told['region']} {own:.4f} (ours {region.told['losses'][-1]:.4f})" for region, own in zip(regions, lost)))

    again = ours(folder)
    mine = {
        "step": [run["step_seconds"]["median"] for run in (told, again)],
        "train": [run["train_seconds"] for run in (told, again)],
        "solve": [run["solve_seconds"]["median"] for run in (told, again)],
    }
    named = {
        "step": "one step, lower face, batch 64",
        "train": f"all seven networks, {told['epochs']} epochs",
        "solve": f"features and seven networks, {told['take_frames']} frames",
    }
    for what, name in named.items():
        best = min(theirs[what], key=theirs[what].get)
        print(f"{name}: ours {mine[what][0] * 1e3:.1f} and {mine[what][1] * 1e3:.1f} ms; PyTorch " + ", ".join(f"{mode} {seconds * 1e3:.1f} ms" for mode, seconds in theirs[what].items()) + f"; ours takes {min(mine[what]) / theirs[what][best]:.2f} to {max(mine[what]) / theirs[what][best]:.2f} of its best ({best})")


if __name__ == "__main__":
    sys.exit(main())
