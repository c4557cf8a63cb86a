#!/usr/bin/env bash
# Makes the Debian packages and looks into them. package_test.sh <build folder>
set -euo pipefail

build="$1"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

cpack --config "$build/CPackConfig.cmake" -B "$work" >"$work/cpack.log" 2>&1 ||
  { cat "$work/cpack.log" >&2; exit 1; }
runtime="$(ls "$work"/colmap-ext_*.deb)"
development="$(ls "$work"/libcolmap-ext-dev_*.deb)"

# Prints the lines of stdin that match, and fails when there is none.
must_have() { grep -E -m1 "$2" <<<"$1" || { echo "missing: $2 in: $1" >&2; exit 1; }; }

depends="$(dpkg-deb -f "$runtime" Depends)"
for package in colmap libembree libopen3d libopencv-core libtbb; do
  must_have "$depends" "(^|, )$package" >/dev/null
done
must_have "$(dpkg-deb -f "$development" Depends)" "libeigen3-dev" >/dev/null
must_have "$(dpkg-deb -c "$runtime")" " \./usr/bin/colmap_ext$"
for program in colmap_ext colmap_ext_flightd colmap_ext_dronesim; do
  must_have "$(dpkg-deb -c "$runtime")" " \./usr/share/man/man1/$program\.1\.gz$"
  must_have "$(dpkg-deb -c "$runtime")" " \./usr/share/bash-completion/completions/$program$"
done
must_have "$(dpkg-deb -c "$development")" " \./usr/include/colmap_ext/scene/reconstruction.h$"
must_have "$(dpkg-deb -c "$development")" "colmap_ext-config.cmake$"
if dpkg-deb -c "$runtime" | grep -q '/include/'; then
  echo "the programs' package holds headers" >&2
  exit 1
fi
dpkg-deb -x "$runtime" "$work/root"
"$work/root/usr/bin/colmap_ext" help >/dev/null
