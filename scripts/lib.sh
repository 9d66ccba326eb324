# shellcheck shell=bash
# Shared by the scripts beside it; sourced, not run. Leaves the caller in the repository's root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'muster: %s\n' "$*"; }

die() {
  printf 'muster: %s\n' "$*" >&2
  exit 3
}

# install_packages [FILE...]: installs what the files (default scripts/packages) name and this
# machine lacks. Silent when nothing is missing.
install_packages() {
  local package missing=() as_root=() log=build/packages.log reason
  command -v apt-get >/dev/null ||
    die "there is no apt-get here; this needs Debian 12 and the packages in ${*:-scripts/packages}"
  while read -r package; do
    [[ $package == '' || $package == '#'* ]] && continue
    # node and npm may come from elsewhere, and then exclude Debian's.
    [[ $package == nodejs || $package == npm ]] && command -v "${package/nodejs/node}" >/dev/null &&
      continue
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
      missing+=("$package")
  done < <(cat "${@:-scripts/packages}")
  ((${#missing[@]})) || return 0

  if [[ $(id -u) != 0 ]]; then
    command -v sudo >/dev/null ||
      die "run this as root once, to install what is missing: apt-get install ${missing[*]}"
    as_root=(sudo)
    [[ -t 0 ]] || as_root=(sudo -n)
  fi
  say "installing with apt-get: ${missing[*]}"
  mkdir -p build
  if ! { "${as_root[@]}" apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends "${missing[@]}"; } </dev/null >"$log" 2>&1; then
    reason=$(grep -m1 -E '^(E:|sudo:)' "$log" || tail -n1 "$log")
    die "apt-get cannot install ${missing[*]}: $reason (all of it: $log)"
  fi
}

# build PRESET TARGET [CMAKE_ARGUMENT...]: configures, and builds that target, in build/PRESET.
build() {
  local preset=$1 target=$2 log jobs
  shift 2
  log=build/$preset/configure.log
  say "building in build/$preset"
  mkdir -p "build/$preset"
  cmake --preset "$preset" "$@" >"$log" 2>&1 || {
    cat "$log" >&2
    die "cannot configure (above, and in $log)"
  }
  # A compilation takes up to 2 GB of memory.
  jobs=$(awk -v most="$(nproc)" '/^MemAvailable/ { n = int($2 / 2e6) }
    END { print (n < 1 ? 1 : n > most ? most : n) }' /proc/meminfo)
  cmake --build --preset "$preset" --target "$target" -j "$jobs" || die "cannot build (above)"
}

# build_programs TARGET: of the preset release. A first build is without the tests and what they
# need; scripts/test adds them.
build_programs() {
  local tests=()
  [[ -e build/release/CMakeCache.txt ]] || tests=(-DBUILD_TESTING=OFF)
  build release "$1" "${tests[@]}"
}
