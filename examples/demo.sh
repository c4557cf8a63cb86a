#!/usr/bin/env bash
# The main job, from a bare Debian 12 to a result to look at: installs what is missing, builds, and
# runs a simulated active capture of the church. Run it again and it goes on where it stopped.
#
#   examples/demo.sh [workspace folder] [further options of active_capture …]
set -euo pipefail
cd "$(dirname "$0")/.."

workspace="${1:-demo_workspace}"
shift || true
echo "== 1/3 packages"
scripts/install_dependencies.sh
echo "== 2/3 build"
scripts/build.sh release -DCOLMAP_EXT_TESTS=OFF
echo "== 3/3 simulated active capture of the church, in $workspace"
build/release/bin/colmap_ext active_capture --workspace_path "$workspace" --scene church "$@"
echo
echo "Open $workspace/report/index.html in a browser to see every iteration."
