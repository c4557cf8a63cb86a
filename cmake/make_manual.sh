#!/bin/sh
# Manual pages and bash completions from the programs' own option tables.
#   make_manual.sh <folder of the programs> <folder to write to>
set -eu
programs="$1"
output="$2"

# A page that could not be made must not be installed: the name only when it is whole.
write() {
  "$@" >"$file.part"
  mv "$file.part" "$file"
}

rm -rf "$output"
mkdir -p "$output/man1" "$output/completions"
for verb in $("$programs/colmap_ext" help --format names); do
  file="$output/man1/colmap_ext-$verb.1"
  write "$programs/colmap_ext" help "$verb" --format man
done
file="$output/man1/colmap_ext.1"
write "$programs/colmap_ext" help --format man
file="$output/completions/colmap_ext"
write "$programs/colmap_ext" help --format completion
for program in colmap_ext_flightd colmap_ext_dronesim; do
  file="$output/man1/$program.1"
  write "$programs/$program" --help_format man
  file="$output/completions/$program"
  write "$programs/$program" --help_format completion
done
gzip -9 -n "$output"/man1/*.1
