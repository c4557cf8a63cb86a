#!/usr/bin/env bash
# The page of a session: one folder that opens in any browser, offline, and can be sent to anybody.
#
#   examples/08_report.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

colmap_ext active_capture --workspace_path "$work/room" --scene boxes --Session.max_iterations 1 \
  --InitialFlight.num_views 24 --SparseUpdate.max_num_features 1500 --Renderer.samples_per_pixel 1 \
  --ModelEvaluator.sample_spacing_m 0.05 --log_level warning

# Anew, into a folder of its own, with small photos.
colmap_ext report_generator --workspace_path "$work/room" --output_path "$work/page" --Page.photo_width_px 320

python3 - "$work/page" <<'PY'
import pathlib, sys
page = pathlib.Path(sys.argv[1])
text = (page / "index.html").read_text()
files = [path for path in page.rglob("*") if path.is_file()]
size = sum(path.stat().st_size for path in files)
print(f"{len(files)} files, {size / 1e6:.1f} MB: open {page / 'index.html'}")
outside = [word for word in ("src=\"http", "href=\"http") if word in text]
sys.exit(0 if len(files) > 4 and size > 1e6 and not outside else f"not as expected: {len(files)} files, {outside}")
PY
