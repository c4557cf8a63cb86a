#!/usr/bin/env bash
# Unit tests under sanitizers, in a build folder of their own (build/address, build/thread):
#
#   scripts/check_sanitizers.sh address [modules …]     AddressSanitizer, UBSan and LeakSanitizer
#   scripts/check_sanitizers.sh thread [modules …]      ThreadSanitizer
#
# Without modules: those that read what others wrote, and those that work in parallel. Sources are
# compiled together (unity build), which is what makes it short enough for CI.
set -euo pipefail
cd "$(dirname "$0")/.."

kind="${1:-}"
shift || true
case "$kind" in
  address) sanitizers=address,undefined flags="" ;;
  # GCC warns of the fences in Asio, which does not need them: its queue has a mutex.
  thread) sanitizers=thread flags="-Wno-tsan" ;;
  *) echo "usage: scripts/check_sanitizers.sh address|thread [modules …]" >&2; exit 2 ;;
esac
modules=("$@")
if ((${#modules[@]} == 0)); then
  modules=(util mavlink geom scene fuzz sfm mvs surface coverage nbv path mission flight sim dense
    eval report session)
fi

start=$SECONDS
cmake -S . -B "build/$kind" -G Ninja -DCMAKE_BUILD_TYPE=Sanitize \
  -DCMAKE_CXX_FLAGS="-O1 -g1 -Wno-subobject-linkage $flags" -DCOLMAP_EXT_SANITIZE="$sanitizers" \
  -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8 >/dev/null
cmake --build "build/$kind" --target "${modules[@]/#/test_}"
echo "Sanitizer $kind: built in $((SECONDS - start)) s"

# Only what is not ours is suppressed; each entry has its reason.
suppressions="$PWD/scripts/sanitizers"
export ASAN_OPTIONS="detect_stack_use_after_return=1:strict_string_checks=1"
export LSAN_OPTIONS="suppressions=$suppressions/leaks.txt:print_suppressions=0"
export UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1"
export TEST_TMPDIR="$PWD/build/$kind/test_tmp"
export TSAN_OPTIONS="suppressions=$suppressions/threads.txt:halt_on_error=0:second_deadlock_stack=1"

logs="build/$kind/logs"
rm -rf "$logs"
mkdir -p "$logs"
# One process a module: what costs most here is to start the libraries.
run_module() {
  local start=$SECONDS status=0
  timeout 1500 "build/$1/bin/test_$2" --gtest_brief=1 >"build/$1/logs/$2.txt" 2>&1 || status=$?
  echo "$status $2 $((SECONDS - start))" >>"build/$1/logs/results"
}
export -f run_module
start=$SECONDS
printf '%s\n' "${modules[@]}" | xargs -P "$(nproc)" -I '{}' bash -c "run_module $kind {}"
echo "Sanitizer $kind: run in $((SECONDS - start)) s"

failed=0
while read -r status module seconds; do
  tests="$(grep -oE '[0-9]+ tests? from' "$logs/$module.txt" | tail -1 | cut -d' ' -f1 || true)"
  reports="$(grep -cE '^(==|WARNING: ThreadSanitizer|.*runtime error:)' "$logs/$module.txt" || true)"
  printf '  %-10s %5s tests %5d s  exit code %d, %d reports\n' "$module" "${tests:-0}" "$seconds" \
    "$status" "$reports"
  ((status == 0 && reports == 0)) || failed=1
done < <(sort -k2 "$logs/results")
if ((failed)); then
  grep -hE -A 25 '^(==.*ERROR|WARNING: ThreadSanitizer|.*runtime error:|\[  FAILED)' "$logs"/*.txt | head -200
  echo "Sanitizer $kind: findings, see $logs" >&2
  exit 1
fi
echo "Sanitizer $kind: clean"
