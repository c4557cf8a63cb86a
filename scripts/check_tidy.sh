#!/usr/bin/env bash
# clang-tidy over our sources with the checks of .clang-tidy: scripts/check_tidy.sh [files …]
set -euo pipefail
cd "$(dirname "$0")/.."

[[ -f build/release/compile_commands.json ]] || scripts/build.sh release
files=("$@")
if ((${#files[@]} == 0)); then
  mapfile -t files < <(find colmap_ext src -name '*.cc' | sort)
fi
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy -p build/release --quiet --extra-arg=-Wno-unknown-warning-option --warnings-as-errors='*'
echo "clang-tidy: ${#files[@]} files are clean"
