# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# Shared by the other scripts: `source` it, do not run it. Needs bash.
# Sets ROOT (the clone) and BUILD (its ignored folder), and puts Debian's own Python first: ROS's
# tools need it.
set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
BUILD=$ROOT/.build
WORKSPACE=$BUILD/ws
export PATH="/usr/bin:$PATH"

say() { printf '== %s\n' "$*"; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# The comment at the head of a script is its help.
show_help() { sed -n '3,/^[^#]/ s/^# \{0,1\}//p' "$0"; }

# Prints the help and ends the script where the first argument asks for it.
help_if_asked() {
  case ${1:-} in -h | --help)
    show_help
    exit 0
    ;;
  esac
}

wrong_usage() {
  printf '%s: %s\n\n' "$(basename "$0")" "$*" >&2
  show_help >&2
  exit 2
}

# A compiler of this package takes up to 1.2 GB: as many at a time as cores and memory allow.
job_count() {
  local by_memory
  by_memory=$(awk '/MemAvailable/ { n = int($2 / 1200000); print (n < 1 ? 1 : n) }' /proc/meminfo)
  local cores
  cores=$(nproc)
  echo $((cores < by_memory ? cores : by_memory))
}

# build_workspace on|off TARGET...: configures the catkin workspace with or without tests and
# builds the targets (none: everything).
build_workspace() {
  local tests=$1
  shift
  mkdir -p "$WORKSPACE/src"
  ln -sfn "$ROOT" "$WORKSPACE/src/kestrel_slam"
  (cd "$WORKSPACE" && catkin_make -j"$(job_count)" -DCMAKE_BUILD_TYPE=Release \
    -DPYTHON_EXECUTABLE=/usr/bin/python3 -DKESTREL_WERROR=ON -DKESTREL_BUILD_BENCHMARKS=OFF \
    -DKESTREL_BUILD_TESTS="$tests" -DCATKIN_ENABLE_TESTING="$tests" "$@")
}

# Enters the environment of the installed package, with its tools as commands. Not that of `devel`:
# there rosrun looks through the clone itself, and finds the programs in its .build once more.
enter_workspace() {
  local setup=$WORKSPACE/install/setup.bash
  [ -f "$setup" ] || die "$setup is missing: run scripts/build"
  set +u
  # shellcheck disable=SC1090
  source "$setup"
  set -u
  export PATH="/usr/bin:$WORKSPACE/install/lib/kestrel_slam:$PATH"
  # ROS writes its logs into the home folder, which not every account has.
  [ -w "${ROS_HOME:-${HOME:-/nowhere}}" ] || export ROS_HOME=$BUILD/ros_home
}
