#!/bin/sh
# Holds committed source files and scripts to 600 lines each: a longer one has several subjects. Says all that it finds;
# exit 1 when there is something.
#   tests/house/file_lengths.sh [ROOT]
set -eu
cd "${1:-.}"

# Each file and how many lines it has; an unpacked archive's have no list.
if [ -e .git ]; then
  git grep -c '' -- '*.h' '*.cpp' '*.ts' '*.mjs' '*.css' '*.cmake' '*CMakeLists.txt' '*.sh' .ci/run script ':!*.json'
else
  grep -rc '' --include='*.h' --include='*.cpp' --include='*.ts' --include='*.mjs' --include='*.css' --include='*.cmake' \
    --include=CMakeLists.txt --include='*.sh' --exclude-dir=build --exclude-dir=node_modules .
fi | awk -F: '
  $NF > 600 { print $1 ": " $NF " lines, more than 600; split it by subject"; found = 1 }
  END { exit found }' >&2
