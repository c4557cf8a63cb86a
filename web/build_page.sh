#!/bin/sh
# build_page.sh <folder of node_modules> <output folder>: fetches the packages of package-lock.json
# (again only when that file changes) and bundles the page. NODE, NPM: the programs. MAY_FAIL=1:
# when npm cannot fetch, says so and leaves it at that.
set -eu
modules=$1
output=$2
sources=$(cd "$(dirname "$0")" && pwd)

mkdir -p "$modules"
if ! cmp -s "$sources/package-lock.json" "$modules/fetched"; then
  rm -f "$modules/fetched"
  cp "$sources/package.json" "$sources/package-lock.json" "$modules/"
  if ! (cd "$modules" && "$NPM" ci --ignore-scripts --no-audit --no-fund --no-update-notifier \
      --loglevel=error --fetch-retries=1 --fetch-timeout=30000 >npm.log 2>&1); then
    echo "The interactive page is not built: npm cannot fetch its packages from the registry:" >&2
    grep -v '^npm warn' "$modules/npm.log" | head -3 | sed 's/^/  /' >&2
    echo "  Everything else works without it. With network, build again." >&2
    if [ "${MAY_FAIL:-0}" = 1 ]; then exit 0; fi
    exit 1
  fi
  cp "$sources/package-lock.json" "$modules/fetched"
fi
exec "$NODE" "$sources/build.js" "$modules/node_modules" "$output"
