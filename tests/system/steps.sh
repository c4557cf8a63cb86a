# What the scripts beside this one have in common; they set $work, a folder for $work/last.log.
step() { echo "== $SECONDS s: $*"; }
fail() { echo "FAILED: $*" >&2; exit 1; }

# Runs a command, its output in a log that is shown when it fails.
quietly() {
  "$@" > "$work/last.log" 2>&1 || { tail -n 30 "$work/last.log" >&2; fail "$*"; }
}
