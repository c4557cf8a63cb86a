#!/usr/bin/env bash
# From a folder of GPS-tagged photos to a coverage map, next views and a mission file. The photos here
# are renders of the built-in gate, taken as a person with a drone would: one orbit.
#
#   examples/01_photos_to_next_views.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

# 1. Photos: 32 poses on a circle, looking at the gate (name x y z yaw_deg pitch_deg).
python3 - >"$work/poses.txt" <<'PY'
import math
for i in range(32):
    angle = 2 * math.pi * i / 32
    x, y = 22 * math.sin(angle), 22 * math.cos(angle)
    print(f"orbit_{i:02d}.jpg {x:.3f} {y:.3f} 15.0 {math.degrees(angle) + 180:.3f} -22")
PY
colmap_ext scene_renderer --scene gate --pose_list_path "$work/poses.txt" --output_path "$work/render"

# 2. One call: sparse model, mesh, coverage, next views, path, mission. The photos were taken 15 m above
#    the take-off place; DJI's drones write that into their photos, these do not say it.
colmap_ext active_capture --workspace_path "$work/site" --image_path "$work/render/images" \
  --Mission.home_below_origin_m 15

# 3. What a person would look at.
cat "$work/site/iterations/000/coverage.json"
ls -l "$work/site/iterations/000/mission.plan" "$work/site/report/index.html"
