#!/usr/bin/env bash
# Runs every numbered example, each in a folder of its own that is removed afterwards.
set -euo pipefail
cd "$(dirname "$0")/.."

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PATH="$PWD/build/release/bin:$PATH"
for example in examples/[0-9][0-9]_*.sh; do
  echo "== $example"
  "$example" "$work/$(basename "$example" .sh)"
done
echo "All examples ran."
