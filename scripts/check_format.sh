#!/usr/bin/env bash
# Fails when a source file is not formatted as .clang-format says; --fix formats them all.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t sources < <(find colmap_ext include src tests bench examples -name '*.cc' -o -name '*.h' | sort)
if [[ "${1:-}" == "--fix" ]]; then
  clang-format -i "${sources[@]}"
else
  clang-format --dry-run --Werror "${sources[@]}"
  echo "Format: ${#sources[@]} files are clean"
fi
