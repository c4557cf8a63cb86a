#!/usr/bin/env bash
# Judges a finished survey: photos and any COLMAP model of them in, what they do not cover out. The photos
# here are renders of a room with cardboard houses, taken from one side only.
#
#   examples/05_judge_a_survey.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

# 1. The survey: 14 photos on an arc in the south (name x y z yaw_deg pitch_deg).
python3 - >"$work/poses.txt" <<'PY'
import math
for i in range(14):
    angle = math.radians(130 + 100 * i / 13)
    x, y = 2.6 * math.sin(angle), 2.6 * math.cos(angle)
    print(f"arc_{i:02d}.jpg {x:.3f} {y:.3f} 2.1 {math.degrees(angle) + 180:.3f} -32")
PY
colmap_ext scene_renderer --scene boxes --texel_scale 2 --Renderer.samples_per_pixel 1 --pose_list_path "$work/poses.txt" \
  --output_path "$work/render" --Simulation.gps_noise_m 0.01 --log_level warning

# 2. Photos to a sparse model, a fast mesh and a surface: each command by itself, on files.
colmap_ext sparse_updater --image_path "$work/render/images" --output_path "$work/sparse" \
  --SparseUpdate.max_num_features 2000 --log_level warning
colmap_ext superpixel_stereo --input_path "$work/sparse" --image_path "$work/render/images" \
  --output_path "$work/mesh" --log_level warning
colmap_ext surface_reconstructor --input_path "$work/mesh/fused.ply" \
  --output_path "$work/mesh/surface.ply" --log_level warning

# 3. Is it enough for 8 mm a pixel?
colmap_ext coverage_evaluator --input_path "$work/sparse" --mesh_path "$work/mesh/surface.ply" \
  --output_path "$work/coverage" --Coverage.ground_sampling_distance_mm 8

# 4. Only the southern sides were photographed, so it must not say that all is well.
python3 - "$work/coverage/coverage.json" <<'PY'
import json, sys
coverage = json.load(open(sys.argv[1]))
print(f"covered {100 * coverage['covered_ratio']:.1f} %: {coverage['covered']} places, not {coverage['uncovered']}")
sys.exit(0 if coverage["uncovered"] > 100 and 0.05 < coverage["covered_ratio"] < 0.95 else "expected a part of it")
PY
ls -l "$work/coverage"
