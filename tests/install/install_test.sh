#!/usr/bin/env bash
# Installs into an empty folder, runs the installed program, and builds and runs a project that finds
# the modules there and nowhere else. install_test.sh <build folder>
set -euo pipefail

here="$(cd "$(dirname "$0")" && pwd)"
build="$1"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/usr" >"$work/install.log"
"$work/usr/bin/colmap_ext" version
for verb in $("$work/usr/bin/colmap_ext" help --format names); do
  gzip -t "$work/usr/share/man/man1/colmap_ext-$verb.1.gz"
done
bash -n "$work/usr/share/bash-completion/completions/colmap_ext"
cmake -S "$here/consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/usr" \
  -DCMAKE_BUILD_TYPE=Release >"$work/configure.log" || { cat "$work/configure.log" >&2; exit 1; }
if grep -rq "$(cd "$here/../.." && pwd)/include" "$work/usr/lib"; then
  echo "the installed targets name the source folder" >&2
  exit 1
fi
cmake --build "$work/build" >"$work/build.log" || { cat "$work/build.log" >&2; exit 1; }
"$work/build/consumer"
