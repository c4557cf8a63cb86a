#!/usr/bin/env bash
# Runs every numbered example, each in a folder of its own that is removed afterwards, and says how long it
# took. The programs are those of build/release, or on the PATH when COLMAP_EXT_BIN names their folder.
set -euo pipefail
cd "$(dirname "$0")/.."

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PATH="${COLMAP_EXT_BIN:-$PWD/build/release/bin}:$PATH"
for example in examples/[0-9][0-9]_*; do
  name="$(basename "${example%.*}")"
  echo "== $example"
  start=$SECONDS
  "$example" "$work/$name"
  echo "-- $example: $((SECONDS - start)) s"
  rm -rf "${work:?}/$name"
done
echo "All examples ran, in $SECONDS s."
