# shellcheck shell=bash
# Shared by the tests beside it; sourced, not run: PREFIX EXAMPLES WORK.
set -euo pipefail
prefix=$1 examples=$2 work=$3
export PATH=$prefix/bin:$PATH PYTHONPATH=$prefix/lib/python3/dist-packages
scenario=$prefix/share/muster/scenarios/random_1.json
rm -rf "$work"
mkdir -p "$work"

fail() {
  echo "$*" >&2
  exit 1
}

# digest FILE: of a summary, as `muster run` and `muster simulate` print it.
digest() { sed -n 's/^digest *//p' "$1"; }

need_python() {
  command -v python3 >/dev/null || {
    echo "skipped: there is no python3 (Debian: apt-get install python3)"
    exit 77
  }
}

# Missions need multicast; `muster run` makes itself a network where it may.
muster doctor >"$work/doctor" 2>&1 || {
  echo "skipped: no missions on this host"
  cat "$work/doctor"
  exit 77
}
