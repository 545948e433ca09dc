#!/bin/sh
# Holds the pages: no line longer than 120 characters, no link to a page or heading that is not there, and no mention of a
# page anywhere in the project that is not there. Says all that it finds; exit 1 when there is something.
#   tests/house/docs.sh [ROOT]
set -eu
cd "${1:-.}"
export LC_ALL=C.UTF-8
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
: >"$work/found"

if [ -e .git ]; then git ls-files '*.md'; else find . -name '*.md' | sed 's|^\./||'; fi >"$work/pages"

# anchors PAGE: its headings as links name them.
anchors() {
  # shellcheck disable=SC2016  # Backticks are Markdown here.
  sed -n '/^```/,/^```/d;s/^##* *//p' "$1" |
    sed 's/\[\([^]]*\)\]([^)]*)/\1/g;s/`//g;s/[^[:alnum:] _-]//g;s/ /-/g' | tr '[:upper:]' '[:lower:]'
}

while read -r page; do
  grep -nE '^.{121,}' "$page" | cut -c1-60 | sed "s|^|$page:|;s|$|... is longer than 120 characters|" >>"$work/found" || true
  # Code is no link. A link is what stands in the round brackets behind square ones.
  # shellcheck disable=SC2016
  sed '/^ *```/,/^ *```/d;s/`[^`]*`//g' "$page" | grep -oE '\]\([^) ]+\)' | sed 's/^](//;s/)$//' >"$work/links" || true
  while read -r link; do
    case "$link" in
      http:* | https:* | mailto:*) continue ;;
    esac
    path=${link%%#*}
    target=$page
    [ -z "$path" ] || target=$(dirname "$page")/$path
    if [ ! -e "$target" ]; then
      echo "$page: there is no $path" >>"$work/found"
    elif [ "$link" != "$path" ] && [ "${target%.md}" != "$target" ] && ! anchors "$target" | grep -qxF "${link#*#}"; then
      echo "$page: $target has no heading #${link#*#}" >>"$work/found"
    fi
  done <"$work/links"
done <"$work/pages"

# Pages that code, scripts and settings mention.
if [ -e .git ]; then
  git grep -nIoE 'docs/[a-z_/]+\.md' -- . ':!*.md' ':!tests/house/docs.sh'
else
  grep -rnIoE --include='*.h' --include='*.cpp' --include='*.toml' --include='*.cmake' 'docs/[a-z_/]+\.md' .
fi >"$work/mentions" 2>/dev/null || true
while IFS= read -r line; do
  [ -e "${line##*:}" ] || echo "${line%:*}: mentions ${line##*:}, which is not there" >>"$work/found"
done <"$work/mentions"
# And what only its author could look up.
if [ -e .git ]; then
  git grep -nIE '\(?facts:? (page|of the|[0-9])' -- . ':!tests/house/docs.sh' | sed 's/$/  <- a reference that no reader has/' >>"$work/found" || true
fi

cat "$work/found" >&2
[ ! -s "$work/found" ]
