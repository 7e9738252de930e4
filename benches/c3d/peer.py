"""Reads a C3D file again and again with ezc3d, and says how much processor time a reading takes: the peer's side."""

import sys
import time

import ezc3d


def main() -> None:
    path, count = sys.argv[1], int(sys.argv[2])
    times = []
    points = 0
    for _ in range(count):
        start = time.process_time()
        take = ezc3d.c3d(path)
        # Positions of all points; what else the file holds is the peer's own choice to read.
        points = take["data"]["points"].shape[1] * take["data"]["points"].shape[2]
        times.append(time.process_time() - start)
    times.sort()
    print("ezc3d", times[0], times[len(times) // 2], points)


main()
