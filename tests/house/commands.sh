#!/bin/sh
# Holds docs/reference/commands.md to what the built programs say of themselves; exit 1, with what differs, when it does not.
#   tests/house/commands.sh FOLDER      the programs' folder
set -eu
cd "$(dirname "$0")/../.."
said=$(mktemp)
trap 'rm -f "$said"' EXIT
script/commands "${1:-build/release/app}" "$said"
diff -u docs/reference/commands.md "$said" >&2 || {
  echo "docs/reference/commands.md is not what the programs say; run script/commands and commit it" >&2
  exit 1
}
