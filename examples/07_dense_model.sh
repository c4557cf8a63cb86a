#!/usr/bin/env bash
# From photos to a dense model on the CPU, and how far it is from the truth. The truth is known because the
# photos are renders.
#
#   examples/07_dense_model.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

# 1. 8 photos on a sixth of a circle around the houses, and the scene itself as a mesh.
python3 - >"$work/poses.txt" <<'PY'
import math
for i in range(8):
    angle = math.radians(150 + 60 * i / 7)
    x, y = 2.6 * math.sin(angle), 2.6 * math.cos(angle)
    print(f"arc_{i:02d}.jpg {x:.3f} {y:.3f} 2.1 {math.degrees(angle) + 180:.3f} -32")
PY
colmap_ext scene_renderer --scene boxes --texel_scale 2 --Renderer.samples_per_pixel 1 --pose_list_path "$work/poses.txt" \
  --output_path "$work/render" --depth 1 --Simulation.gps_noise_m 0.01 --log_level warning

# 2. Sparse, then dense: fused.ply, surface.ply and COLMAP's depth maps.
colmap_ext sparse_updater --image_path "$work/render/images" --output_path "$work/sparse" \
  --SparseUpdate.max_num_features 2000 --log_level warning
colmap_ext dense_reconstructor --input_path "$work/sparse" --image_path "$work/render/images" \
  --output_path "$work/dense" --backend builtin --DenseStereo.num_partners 4 --SurfaceReconstructor.depth 8 \
  --log_level warning

# 3. Its depth maps against the true ones.
colmap_ext model_evaluator --depth_path "$work/dense/stereo/depth_maps" \
  --ground_truth_path "$work/render/stereo/depth_maps" --output_path "$work/evaluation.json"

python3 - "$work/evaluation.json" <<'PY'
import json, sys
evaluation = json.load(open(sys.argv[1]))
error = evaluation["relative_error"]["median"]
print(f"{100 * evaluation['valid_share']:.0f} % of the pixels have a depth, median error {100 * error:.2f} %")
sys.exit(0 if evaluation["valid_share"] > 0.3 and error < 0.02 else "the model is worse than expected")
PY
ls -l "$work/dense"/*.ply
