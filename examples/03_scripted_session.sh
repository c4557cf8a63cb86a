#!/usr/bin/env bash
# A session that a script drives: what would be done, the log as JSON, a hook after every iteration, how far
# it is, and a limit that is raised later.
#
#   examples/03_scripted_session.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

cat >"$work/session.ini" <<INI
scene = boxes
workspace_path = $work/room
log_format = json
on_iteration = echo "iteration \$COLMAP_EXT_ITERATION: \$COLMAP_EXT_PHOTOS photos, \$COLMAP_EXT_COVERED_RATIO covered" >>$work/told.txt

[Session]
max_iterations = 1
pictures = 0

[InitialFlight]
num_views = 24

[SparseUpdate]
max_num_features = 1500

[Simulation]
width = 480
height = 276
focal_px = 360

[Renderer]
samples_per_pixel = 1
ambient_rays = 0

[ModelEvaluator]
sample_spacing_m = 0.05
INI

echo "-- what would be done"
colmap_ext active_capture --project_path "$work/session.ini" --dry_run 2>/dev/null
test ! -e "$work/room" # nothing was

echo "-- the first iteration"
colmap_ext active_capture --project_path "$work/session.ini" 2>"$work/log.jsonl" >/dev/null
colmap_ext active_capture --workspace_path "$work/room" --status

echo "-- one more"
colmap_ext active_capture --project_path "$work/session.ini" --Session.max_iterations 2 2>>"$work/log.jsonl"

# The log says what happened, and how long each stage took.
python3 - "$work/log.jsonl" "$work/told.txt" <<'PY'
import json, sys
events = [json.loads(line) for line in open(sys.argv[1])]
for event in events:
    if event["event"] == "stage":
        print(f"  {event['iteration']} {event['stage']:<12}{event['wall_s']:7.2f} s")
    if event["event"] == "message" and "option changed" in event["message"]:
        print("  " + event["message"])
iterations = [event for event in events if event["event"] == "iteration"]
told = open(sys.argv[2]).read().splitlines()
print("\n".join(told))
ends = [event["exit_code"] for event in events if event["event"] == "end"]
changed = any("max_iterations: 1 before, 2 now" in event.get("message", "") for event in events)
good = len(iterations) == len(told) == 2 and ends == [0, 0] and changed
good = good and iterations[1]["covered_ratio"] > iterations[0]["covered_ratio"]
sys.exit(0 if good else "not as expected: %s %s %s" % (iterations, told, ends))
PY
