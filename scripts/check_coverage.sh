#!/usr/bin/env bash
# Line coverage of src/ by the unit tests: scripts/check_coverage.sh [least percentage, default 85]
# Writes build/coverage/coverage.txt (a line a file). Needs Debian's package gcovr.
set -euo pipefail
cd "$(dirname "$0")/.."

goal="${1:-85}"
modules=(util mavlink geom scene fuzz sfm mvs surface coverage nbv path mission flight sim dense eval
  report session)
cmake -S . -B build/coverage -G Ninja -DCMAKE_BUILD_TYPE=Coverage -DCMAKE_CXX_FLAGS="-O1 --coverage -fprofile-update=atomic" \
  -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8 >/dev/null
cmake --build build/coverage --target "${modules[@]/#/test_}"
find build/coverage -name '*.gcda' -delete
# Counters of one file must not be written by two programs at once.
for module in "${modules[@]}"; do
  timeout 1500 "build/coverage/bin/test_$module" --gtest_brief=1 >"build/coverage/$module.txt" 2>&1 ||
    echo "warning: test_$module failed: build/coverage/$module.txt" >&2
done
gcovr --root . --filter 'src/' --object-directory build/coverage --exclude-unreachable-branches \
  -j "$(nproc)" --txt build/coverage/coverage.txt --fail-under-line "$goal" --print-summary
