#!/usr/bin/env bash
# All tests, from a bare Debian 12: installs what is missing, builds with tests, checks the format,
# and runs every test, whole commands with the real `colmap` among them.
set -euo pipefail
cd "$(dirname "$0")/.."

echo "== 1/4 packages"
scripts/install_dependencies.sh --tests
echo "== 2/4 format"
scripts/check_format.sh
echo "== 3/4 build"
scripts/build.sh release -DCOLMAP_EXT_TESTS=ON
echo "== 4/4 tests"
ctest --test-dir build/release --parallel "$(nproc)" --output-on-failure "$@"
