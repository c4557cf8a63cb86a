#!/usr/bin/env bash
# Configures and builds one preset: scripts/build.sh [release|debug|asan] [cmake options …]
set -euo pipefail
cd "$(dirname "$0")/.."

preset="${1:-release}"
shift || true
echo "Build: preset $preset in build/$preset"
cmake --preset "$preset" "$@" >"/tmp/colmap_ext_configure.$$" 2>&1 || {
  cat "/tmp/colmap_ext_configure.$$" >&2
  exit 1
}
rm -f "/tmp/colmap_ext_configure.$$"
cmake --build --preset "$preset"
