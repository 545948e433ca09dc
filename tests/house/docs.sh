#!/bin/sh
# Holds the pages: no line longer than 120 characters, no link to a page or heading that is not there, and no mention of a
# page (docs/page.md) or of its heading (page.md, "Heading") anywhere in the project that is not there. Pages have no
# numbered sections to mention. Says all that it finds; exit 1 when there is something.
#   tests/house/docs.sh [ROOT]
set -eu
cd "${1:-.}"
export LC_ALL=C.UTF-8
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
: >"$work/found"

if [ -e .git ]; then git ls-files '*.md'; else find . -name '*.md' | sed 's|^\./||'; fi >"$work/pages"

# headings PAGE: the text of each.
headings() {
  # shellcheck disable=SC2016  # Backticks are Markdown here.
  sed -n '/^```/,/^```/d;s/^##* *//p' "$1" | sed 's/\[\([^]]*\)\]([^)]*)/\1/g;s/`//g'
}

# anchors PAGE: its headings as links name them.
anchors() {
  headings "$1" | sed 's/[^[:alnum:] _-]//g;s/ /-/g' | tr '[:upper:]' '[:lower:]'
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

# Pages that code, scripts and settings mention. The tree that this check is tested on is wrong on purpose.
if [ -e .git ]; then
  git grep -nIoE 'docs/[A-Za-z0-9_/-]+\.md' -- . ':!*.md' ':!tests/house/docs.sh' ':!tests/house/wrong'
else
  grep -rnIoE --include='*.h' --include='*.cpp' --include='*.toml' --include='*.cmake' 'docs/[A-Za-z0-9_/-]+\.md' .
fi | sed 's|^\./||' >"$work/mentions" || true
while IFS= read -r line; do
  [ -e "${line##*:}" ] || echo "${line%:*}: mentions ${line##*:}, which is not there" >>"$work/found"
done <"$work/mentions"
# Their headings, and sections by number. A mention may go on in the comment's next line: a line here is a whole file.
page='[A-Za-z0-9_/-]+\.md'
heading="${page}, \"[^\"]+\""
section="${page}[,;:]? *\(?([Ss]ections?|§) ?[0-9][0-9.]*|([Ss]ections?|§) ?[0-9][0-9.]* (of|in) ${page}"
# shellcheck disable=SC2016  # Awk's $0.
sed 's/:.*//' "$work/mentions" | sort -u | tr '\n' '\0' | xargs -0 -r awk '
  FNR == 1 { printf "%s%s: ", separator, FILENAME; separator = "\n" }
  { sub(/^[ \t]*(\/\/+|#+|\*+)[ \t]*/, ""); printf "%s ", $0 }
  END { print "" }' | grep -E "$heading|$section" >"$work/files" || true
while IFS= read -r text; do
  file=${text%%: *}
  printf '%s\n' "$text" | grep -oE "$heading" | sed 's/"$//' >"$work/headings" || true
  while IFS= read -r line; do
    target=${line%%, \"*}
    [ -e "$target" ] || continue # Complained of above.
    headings "$target" | grep -qxF "${line#*, \"}" ||
      echo "$file: $target has no heading \"${line#*, \"}\"" >>"$work/found"
  done <"$work/headings"
  printf '%s\n' "$text" | grep -oE "$section" | sed "s|^|$file: pages have headings, not numbered sections: |" >>"$work/found" || true
done <"$work/files"
# And what only its author could look up.
if [ -e .git ]; then
  git grep -nIE '\(?facts:? (page|of the|[0-9])' -- . ':!tests/house/docs.sh' | sed 's/$/  <- a reference that no reader has/' >>"$work/found" || true
fi

cat "$work/found" >&2
[ ! -s "$work/found" ]
