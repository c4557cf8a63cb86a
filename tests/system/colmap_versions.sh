#!/usr/bin/env bash
# Runs the loop, and COLMAP's own commands on what it wrote, with the colmap of another Debian:
#   sudo tests/system/colmap_versions.sh [trixie|sid] [program]
# `program` is colmap_ext, default build/release/bin/colmap_ext. Only colmap is of the other Debian,
# in a root that debootstrap makes; our program runs here and gets a --colmap_path that leads there.
# The root is kept in COLMAP_EXT_ROOTS (default /var/tmp/colmap_ext_roots, 1.5 GB each) for the next
# time. Needs root rights for chroot and mounts; the mounts are private to this script and end with
# it, however it ends.
set -euo pipefail

if [[ "$(id -u)" != 0 ]]; then
  echo "$0: needs root rights (debootstrap, chroot); run it by sudo" >&2
  exit 2
fi
if [[ "${COLMAP_EXT_UNSHARED:-}" != yes ]]; then
  COLMAP_EXT_UNSHARED=yes exec unshare --mount --propagation private "$0" "$@"
fi

suite="${1:-trixie}"
program="$(realpath "${2:-$(dirname "$0")/../../build/release/bin/colmap_ext}")"
root="${COLMAP_EXT_ROOTS:-/var/tmp/colmap_ext_roots}/$suite"
work="$(mktemp -d /var/tmp/colmap_ext_versions.XXXXXX)"
colmap="$work/colmap"
trap 'rm -rf "$work"' EXIT
[[ -x "$program" ]] || { echo "$program: build colmap_ext first (scripts/build.sh)" >&2; exit 2; }

. "$(dirname "$0")/steps.sh"

make_root() {
  command -v debootstrap > /dev/null || quietly apt-get install -y --no-install-recommends debootstrap
  if [[ ! -e "$root/etc/debian_version" ]]; then
    step "debootstrap $suite"
    mkdir -p "$root"
    quietly debootstrap --variant=minbase "$suite" "$root" http://deb.debian.org/debian
  fi
  if [[ ! -x "$root/usr/bin/colmap" ]]; then
    step "colmap of $suite"
    # The age of a mirror's list says nothing about this test.
    quietly chroot "$root" apt-get -o APT::Sandbox::User=root -o Acquire::Check-Valid-Until=false update
    quietly chroot "$root" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends colmap
  fi
}

# The same paths inside as here, and a program here that runs colmap there.
connect_root() {
  mount -t proc proc "$root/proc"
  mkdir -p "$root$work"
  mount --bind "$work" "$root$work"
  printf '#!/bin/sh\nexec chroot "%s" colmap "$@"\n' "$root" > "$colmap"
  chmod +x "$colmap"
  export QT_QPA_PLATFORM=offscreen OMP_WAIT_POLICY=passive
}

checksums() { (cd "$1" && find . -type f -not -name '*-shm' -not -name '*-wal' -exec sha256sum {} + | sort); }

registered() {
  "$colmap" model_analyzer --path "$1" 2>&1 |
    sed -n 's/.*Registered images: *\([0-9]*\).*/\1/p' | head -n 1
}

run_loop() {
  step "active_capture, 2 iterations"
  quietly "$program" active_capture --workspace_path "$work/session" --scene boxes \
    --colmap_path "$colmap" --Session.max_iterations 2 --InitialFlight.num_views 28 \
    --Session.pictures 0 --Session.vehicle embedded
  grep -E "registered|georegistered|covered" "$work/last.log" | tail -n 8 || true
  local iteration count
  for iteration in "$work"/session/iterations/*/; do
    count="$(registered "$iteration/sparse")"
    echo "   $(basename "$iteration"): $count photos by model_analyzer; $(ls "$iteration/sparse" | tr '\n' ' ')"
    [[ "${count:-0}" -ge 20 ]] || fail "model_analyzer reads $count photos of $iteration/sparse"
  done
}

# A project as a user of that colmap makes it: other names than the session's.
make_project() {
  step "a project made by that colmap alone"
  local project="$work/project" gpu=SiftExtraction match=SiftMatching name
  "$colmap" feature_extractor -h 2>&1 | grep FeatureExtraction.use_gpu > /dev/null &&
    gpu=FeatureExtraction match=FeatureMatching
  mkdir -p "$project/images" "$project/sparse" "$work/more"
  local all=()
  mapfile -t all < <(cd "$work/session/images" && find . -name '*.jpg' | sort | head -n 28)
  for name in "${all[@]:0:20}"; do
    cp "$work/session/images/$name" "$project/images/flight_$(basename "$name")"
  done
  quietly "$colmap" feature_extractor --database_path "$project/database.db" \
    --image_path "$project/images" --ImageReader.single_camera 1 "--$gpu.use_gpu" 0 \
    --SiftExtraction.first_octave 0
  quietly "$colmap" exhaustive_matcher --database_path "$project/database.db" "--$match.use_gpu" 0
  quietly "$colmap" mapper --database_path "$project/database.db" --image_path "$project/images" \
    --output_path "$project/sparse" --Mapper.multiple_models 0
  cp -r "$project/images/." "$work/more"
  for name in "${all[@]:20:8}"; do
    cp "$work/session/images/$name" "$work/more/flight_$(basename "$name")"
  done
}

update_project() {
  step "sparse_updater on that project, 8 more photos"
  local project="$work/project" before
  checksums "$project" > "$work/before.txt"
  before="$(registered "$project/sparse/0")"
  quietly "$program" sparse_updater --colmap_path "$colmap" --image_path "$work/more" \
    --database_path "$project/database.db" --input_path "$project/sparse/0" \
    --output_path "$work/updated"
  grep "photos registered" "$work/last.log" || true
  checksums "$project" | cmp - "$work/before.txt" || fail "the project was changed"
  local after
  after="$(registered "$work/updated")"
  echo "   $before photos before, $after after; $(ls "$work/updated" | tr '\n' ' ')"
  [[ "${after:-0}" -gt "${before:-0}" ]] || fail "no photo was added"
}

# COLMAP's own commands on models and databases that we wrote.
check_with_colmap() {
  step "colmap's own commands on what we wrote"
  local latest
  latest="$(find "$work/session/iterations" -mindepth 1 -maxdepth 1 | sort | tail -n 1)/sparse"
  mkdir -p "$work/adjusted" "$work/compared" "$work/continued"
  quietly "$colmap" bundle_adjuster --input_path "$work/updated" --output_path "$work/adjusted"
  quietly "$colmap" bundle_adjuster --input_path "$latest" --output_path "$work/adjusted"
  echo "   bundle_adjuster: $(registered "$work/adjusted") photos"
  quietly "$colmap" model_comparer --input_path1 "$work/updated" \
    --input_path2 "$work/project/sparse/0" --output_path "$work/compared" \
    $("$colmap" model_comparer -h 2>&1 | grep alignment_error > /dev/null && echo "--alignment_error proj_center --max_proj_center_error 1")
  grep -iE "common|rotation|Avg|median" "$work/last.log" | head -n 4 || true
  quietly "$colmap" database_merger --database_path1 "$work/session/database.db" \
    --database_path2 "$work/updated/database.db" --merged_database_path "$work/merged.db"
  echo "   database_merger: $(stat -c %s "$work/merged.db") bytes"
  quietly "$colmap" mapper --database_path "$work/updated/database.db" \
    --image_path "$work/more" --input_path "$work/updated" --output_path "$work/continued"
  echo "   mapper --input_path: $(registered "$work/continued") photos"
  # And we read what it wrote, and find nothing to do.
  quietly "$program" sparse_updater --colmap_path "$colmap" --image_path "$work/more" \
    --database_path "$work/updated/database.db" --input_path "$work/continued" \
    --output_path "$work/again"
  tail -n 1 "$work/last.log"
}

make_root
connect_root
step "$("$colmap" help 2>&1 | grep -o "COLMAP [0-9].*" | tail -n 1)"
run_loop
make_project
update_project
check_with_colmap
step "all passed with the colmap of $suite"
