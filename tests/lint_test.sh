#!/bin/bash
# Plants defects in files that are compiled together, as scripts/lint compiles them, and expects the
# rules of .clang-tidy to find each: one in a .cc file, one in a header. The same files without the
# defects must pass. Exit code 77: there is no clang-tidy-14 here.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
command -v clang-tidy-14 >/dev/null || { echo "skipped: there is no clang-tidy-14"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/tools/planted"

# write LINES: a function of so many lines of its own, and a parameter that is copied for nothing
# where there are more than 80.
write() {
  local parameter='const std::string& text'
  (($1 > 80)) && parameter='std::string text'
  printf '#pragma once\n#include <string>\ninline std::size_t Size(%s) { return text.size(); }\n' \
    "$parameter" >"$work/tools/planted/planted.h"
  {
    printf '#include "tools/planted/planted.h"\nint Long(int x) {\n'
    for ((i = 0; i < $1; ++i)); do printf '  x += %d;\n' "$i"; done
    printf '  return x;\n}\n'
  } >"$work/tools/planted/planted.cc"
  printf '#include "tools/planted/planted.cc"\n' >"$work/unity.cc"
}
lint() {
  clang-tidy-14 --config-file="$root/.clang-tidy" --checks=-bugprone-suspicious-include --quiet \
    "$work/unity.cc" -- -std=c++20 "-I$work" 2>&1
}

write 70
lint >"$work/out" || { cat "$work/out"; echo "files without a defect are refused"; exit 1; }
write 123
if lint >"$work/out"; then echo "the defects are not found"; exit 1; fi
for finding in readability-function-size performance-unnecessary-value-param; do
  grep -q "$finding" "$work/out" || { cat "$work/out"; echo "not found: $finding"; exit 1; }
done
