#!/usr/bin/env bash
# Reads one C3D file with grimace and with ezc3d (Python, C++ inside), turn and turn about in one run, and compares the
# processor time of a reading. Usage: benches/c3d/run.sh FILE [COUNT]; PYTHON names a Python that has ezc3d.
set -euo pipefail
file=$(realpath "${1:?a C3D file}")
count=${2:-30}
python=${PYTHON:-python3}
cd "$(dirname "$0")/../.."
cargo build --quiet --release -p face-io --example read_c3d
ours=${CARGO_TARGET_DIR:-target}/release/examples/read_c3d
for _ in 1 2 3; do
    "$ours" "$file" "$count"
    "$python" benches/c3d/peer.py "$file" "$count"
done | awk '
    { if (!($1 in best) || $2 < best[$1]) best[$1] = $2; if (!($1 in median) || $3 < median[$1]) median[$1] = $3; points[$1] = $4 }
    END {
        for (name in best) printf "%-8s %9.3f ms at best, %9.3f ms in the middle, %d points\n", name, 1000 * best[name], 1000 * median[name], points[name]
        printf "ezc3d takes %.1f times as long at best, %.1f in the middle\n", best["ezc3d"] / best["grimace"], median["ezc3d"] / median["grimace"]
        if (points["ezc3d"] != points["grimace"]) { print "the two read different counts of points"; exit 1 }
    }'
