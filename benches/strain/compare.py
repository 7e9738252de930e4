"""Solves the problems that the benchmark `strain` wrote, with NumPy and SciPy, and prints both sides' times."""
import json, sys, time
from pathlib import Path
import numpy as np
from scipy.linalg import solveh_banded
from scipy.optimize import least_squares, lsq_linear
from scipy.sparse import lil_matrix

folder = Path(sys.argv[1])
ours = json.loads((folder / "ours.json").read_text())
read = lambda name: np.fromfile(folder / name, dtype="<f8")
T, N, S = int(ours["frames"]), int(ours["vertices"]), int(ours["strains"])

def row(what, theirs, mine, off):
    print(f"| {what} | {theirs:.4f} s | {mine:.4f} s | {theirs / mine:.0f} | {off:.1e} |")

print(f"{T} frames, {N} vertices, {S} strains")
print("| problem | NumPy/SciPy | grimace | times | greatest difference |\n|---|---|---|---|---|")

# A.1: bounded least squares, a vertex at a time.
k = int(ours["skin_vertices"])
motion, target = read("skin_motion.bin").reshape(k, 3 * T), read("skin_target.bin").reshape(k, 3 * T)
start, found, prior = read("skin_start.bin"), read("skin_found.bin"), np.sqrt(9e-8 * T)
begin, off = time.perf_counter(), 0.0
for i in range(k):
    a, b = np.append(motion[i], prior)[:, None], np.append(target[i], prior * start[i])
    off = max(off, abs(lsq_linear(a, b, (0, 1), tol=1e-12).x[0] - found[i]))
theirs = (time.perf_counter() - begin) / k
row("skinning, a vertex (A.1)", theirs, ours["skinning_seconds"] / N, off)

# A.3: normal equations, all vertices in batches; E, then the strains, then E.
V, G = read("unposed.bin").reshape(T, 3 * N), read("strains.bin").reshape(T, S)
D = read("penalties.bin").reshape(N, S)
def shapes(G):
    gram, right = G.T @ G, (G.T @ V).reshape(S, N, 3)
    E = np.empty((3 * N, S))
    for first in range(0, N, 256):
        d = D[first:first + 256]
        systems = gram[None] + (1e-9 * T) * np.eye(S)[None] * (d * d)[:, None, :]
        E[3 * first:3 * (first + len(d))] = np.linalg.solve(systems, right[:, first:first + 256].transpose(1, 0, 2)).transpose(0, 2, 1).reshape(-1, S)
    return E
begin = time.perf_counter()
E = shapes(G)
refined = np.linalg.solve(E.T @ E + 1e-6 * np.eye(S), E.T @ V.T + 1e-6 * G.T).T
E = shapes(refined)
theirs = time.perf_counter() - begin
mine = read("shapes.bin").reshape(S, 3 * N).T
row("strain shapes, one round (A.3)", theirs, ours["shapes_seconds"], np.abs(refined @ (E - mine).T).max())

# B.3: the whole take as one banded system of normal equations.
E = mine
second = np.zeros((T, T))
for t in range(T):
    second[t, t] -= 2
    second[t, max(t - 1, 0)] += 1
    second[t, min(t + 1, T - 1)] += 1
couple = 4e-4 * (second.T @ second)
def solve_band(gram, right):
    band = np.zeros((2 * S + 1, T * S))
    for t in range(T):
        own = gram(t) + 1e-8 * np.eye(S)
        for i in range(S):
            band[:S - i, t * S + i] = own[i:, i]
        for step in range(3):
            if t + step < T:
                band[step * S, t * S:(t + 1) * S] += couple[t, t + step]
    return solveh_banded(band, right.reshape(-1), lower=True, overwrite_ab=True).reshape(T, S)
answer = read("solved.bin").reshape(T, S)
off = lambda solved: np.abs((solved - answer) @ E.T).max()

# As if no joint turned the skin: one matrix for all frames.
begin = time.perf_counter()
one = E.T @ E
solved = solve_band(lambda t: one, V @ E)
theirs = time.perf_counter() - begin
row("strain solve (B.3), the other side on the rest pose", theirs, ours["solve_seconds"], off(solved))

# The same problem: every frame's shapes turned by its joints.
left, turns, skin = read("left.bin").reshape(T, 3 * N), read("turns.bin").reshape(T, 3, 3), read("skin.bin")
begin = time.perf_counter()
right = np.empty((T, S))
def gram(t):
    turned = (E.reshape(N, 3, S) + skin[:, None, None] * ((turns[t] - np.eye(3)) @ E.reshape(N, 3, S))).reshape(3 * N, S)
    right[t] = left[t] @ turned
    return turned.T @ turned
solved = solve_band(gram, right)
theirs = time.perf_counter() - begin
row("strain solve (B.3)", theirs, ours["solve_seconds"], off(solved))

# B.2: sparse least squares.
J = int(ours["jaw_frames"])
rest, weights, pivot = read("jaw_rest.bin").reshape(-1, 3), read("jaw_weights.bin"), read("jaw_pivot.bin")
n = len(rest)
target, found = read("jaw_target.bin").reshape(J, n, 3), read("jaw_found.bin").reshape(J, 6)
def residual(theta):
    theta = theta.reshape(J, 6)
    (x, y, z), shift = theta[:, :3].T, 0.1 * theta[:, 3:]
    cx, sx, cy, sy, cz, sz = np.cos(x), np.sin(x), np.cos(y), np.sin(y), np.cos(z), np.sin(z)
    R = np.array([[cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
                  [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
                  [-sy, cy * sx, cy * cx]]).transpose(2, 0, 1)
    moved = (rest - pivot) @ R.transpose(0, 2, 1) + pivot + shift[:, None] - rest
    posed = rest + weights[None, :, None] * moved
    padded = np.concatenate([theta[:1], theta, theta[-1:]])
    calm = 0.1 * (padded[:-2] - 2 * padded[1:-1] + padded[2:])
    return np.concatenate([(posed - target).ravel(), calm.ravel()])
pattern = lil_matrix((J * n * 3 + 6 * J, 6 * J), dtype=int)
for t in range(J):
    pattern[t * n * 3:(t + 1) * n * 3, 6 * t:6 * t + 6] = 1
    for i in range(6):
        for other in (max(t - 1, 0), t, min(t + 1, J - 1)):
            pattern[J * n * 3 + 6 * t + i, 6 * other + i] = 1
begin = time.perf_counter()
answer = least_squares(residual, np.zeros(6 * J), jac_sparsity=pattern.tocsr(), method="trf", x_scale="jac")
theirs = time.perf_counter() - begin
theta = answer.x.reshape(J, 6) * np.array([1, 1, 1, 0.1, 0.1, 0.1])
row(f"jaw, {J} frames of {n} vertices (B.2)", theirs, ours["jaw_seconds"], np.abs(theta - found).max())
print("\nGrowth, from half of the frames to all:")
for name in ["skinning_seconds", "shapes_seconds", "solve_seconds"]:
    print(f"- {name}: {ours[name + '_half_frames']:.3f} s to {ours[name]:.3f} s")
half, all = (f"{ours[f'jaw_seconds_all{part}']:.3f} s, {ours[f'jaw_steps_all{part}']:.0f} steps" for part in ("_half_frames", ""))
print(f"- jaw on all vertices: {half} to {all}")
