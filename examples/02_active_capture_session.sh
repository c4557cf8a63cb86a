#!/usr/bin/env bash
# A scripted active capture session: options in a file, a simulated drone, two flights after the first.
#
#   examples/02_active_capture_session.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

cat >"$work/session.ini" <<'INI'
scene = boxes
preset = indoor

[Session]
max_iterations = 3

[InitialFlight]
num_views = 40
INI
colmap_ext active_capture --workspace_path "$work/room" --project_path "$work/session.ini"

# The summary is machine-readable: stop the script when the coverage did not rise.
python3 - "$work/room/summary.json" <<'PY'
import json, sys
summary = json.load(open(sys.argv[1]))
ratios = [iteration["covered_ratio"] for iteration in summary["iterations"]]
print("covered after each iteration:", ", ".join(f"{100 * ratio:.1f} %" for ratio in ratios))
sys.exit(0 if ratios[-1] > ratios[0] else "coverage did not rise")
PY
