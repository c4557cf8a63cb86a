#!/usr/bin/env bash
# Installs the Debian packages that colmap_ext needs to be built, run and tested. Does nothing when
# they are all there. Needs root or sudo. What each package is for: docs/dependencies.md.
set -euo pipefail

packages=(
  build-essential cmake ninja-build
  colmap
  libassimp-dev libboost-dev libboost-program-options-dev libceres-dev libcgal-dev libeigen3-dev
  libembree-dev libexiv2-dev libflann-dev libgeographiclib-dev libminizip-dev libopen3d-dev libopencv-dev
  libsqlite3-dev libssl-dev libtbb-dev nlohmann-json3-dev zlib1g-dev
)
# Node and npm may come from elsewhere than Debian, in one package.
command -v node >/dev/null || packages+=(nodejs)
command -v npm >/dev/null || packages+=(npm)
if [[ "${1:-}" == "--tests" ]]; then
  packages+=(libgtest-dev libgmock-dev clang-format clang-tidy gdal-bin libxml2-utils python3 sqlite3)
  packages+=(chromium faketime openmpi-bin unzip)
fi

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "Packages: all ${#packages[@]} are installed"
else
  as_root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || { echo "error: installing packages needs root or sudo" >&2; exit 1; }
    as_root=(sudo)
  fi
  echo "Packages: installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${missing[@]}"
fi

# The independent MAVLink implementation that the tests talk to, as its lock file says.
peer="$(dirname "$0")/../tests/mavlink/peer"
if [[ "${1:-}" == "--tests" && "$peer/package-lock.json" -nt "$peer/node_modules/.package-lock.json" ]]; then
  npm ci --prefix "$peer" --ignore-scripts --no-audit --no-fund
fi
