# shellcheck shell=sh
# What every script here stands on; read with `. script/ground.sh` from the root of the project.
# Packages come from the lists in script/packages, and only those that are missing are installed.

# These two, where a machine sets them, put OpenBLAS on kernels of half the speed.
unset OPENBLAS_CORETYPE OPENBLAS_L2_SIZE

say() { printf '%s\n' "$*"; }
stop() {
  printf '%s: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

cores() { nproc 2>/dev/null || echo 2; }

# as_root COMMAND...: runs it as root, through sudo where we are somebody else.
as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null 2>&1; then
    sudo "$@"
  else
    stop "installing packages needs root; run as root, install sudo, or install by hand: $*"
  fi
}

# listed LIST...: the packages of script/packages/LIST.txt, comments left out.
listed() {
  for list in "$@"; do
    sed -e 's/#.*//' "script/packages/$list.txt"
  done | tr -s ' \t\n' '\n' | sed '/^$/d' | sort -u
}

# need LIST...: makes sure that the packages of these lists are installed. Quick, and silent, when they are.
need() {
  # shellcheck disable=SC2046
  set -- $(listed "$@")
  have=$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' "$@" 2>/dev/null | sed -n 's/^.i *//p')
  missing=
  for package in "$@"; do
    printf '%s\n' "$have" | grep -qxF "$package" || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  command -v apt-get >/dev/null 2>&1 || stop "there is no apt-get here; please install:$missing"
  say "Installing Debian packages:$missing"
  as_root apt-get update -qq || stop "apt-get update failed; is there a network?"
  # shellcheck disable=SC2086
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $missing >/dev/null ||
    stop "apt-get could not install:$missing"
}

# lists_with_npm LIST...: the same lists, and npm's where there is no node or npm.
lists_with_npm() {
  if ! command -v node >/dev/null 2>&1 || ! command -v npm >/dev/null 2>&1; then
    set -- "$@" npm
  fi
  echo "$@"
}

# npm_modules FOLDER...: the locked npm packages of each (script/npm, script/onnxruntime), in its node_modules.
npm_modules() {
  for folder in "$@"; do
    [ -n "$(find "$folder/package-lock.json" -newer "$folder/node_modules/.package-lock.json" 2>&1)" ] || continue
    say "Installing npm packages of $folder"
    (cd "$folder" && npm ci --no-audit --no-fund --loglevel=error) || stop "npm could not install $folder"
  done
}

# cpp_files: our own C++ files, each ended by a NUL: the committed ones, or all that an unpacked archive has.
cpp_files() {
  if [ -e .git ]; then
    git ls-files -z '*.h' '*.cpp' || stop "git cannot list the committed files"
  else
    find app examples fuzz lab mien tests \( -name '*.h' -o -name '*.cpp' \) -print0
  fi
}
