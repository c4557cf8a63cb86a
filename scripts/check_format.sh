#!/usr/bin/env bash
# Fails when a source file is not formatted as .clang-format says, or a Python script is not Python;
# --fix formats the sources.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t sources < <(find colmap_ext include src tests bench examples -name '*.cc' -o -name '*.h' | sort)
if [[ "${1:-}" == "--fix" ]]; then
  clang-format -i "${sources[@]}"
else
  clang-format --dry-run --Werror "${sources[@]}"
  mapfile -t scripts < <(find examples tests -name '*.py' -not -path '*/node_modules/*' | sort)
  python3 -c 'import ast, sys
for path in sys.argv[1:]:
    ast.parse(open(path, encoding="utf-8").read(), path)' "${scripts[@]}"
  echo "Format: ${#sources[@]} files and ${#scripts[@]} scripts are clean"
fi
