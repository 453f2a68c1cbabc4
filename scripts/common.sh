# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# Shared functions of the other scripts. Use it with `source` in bash.
# Sets ROOT (the clone) and BUILD (its build folder). Puts /usr/bin first in PATH, because the ROS
# tools need Debian's Python.
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

# Prints the comment at the head of the script as its help.
show_help() { sed -n '3,/^[^#]/ s/^# \{0,1\}//p' "$0"; }

# Prints the help and exits if the first argument is -h or --help.
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

# Number of parallel compilers, limited by the number of cores and by memory (1.2 GB for each).
job_count() {
  local by_memory
  by_memory=$(awk '/MemAvailable/ { n = int($2 / 1200000); print (n < 1 ? 1 : n) }' /proc/meminfo)
  local cores
  cores=$(nproc)
  echo $((cores < by_memory ? cores : by_memory))
}

# Compilers run behind ccache where that is installed: the core is compiled once, though both builds
# need it. That works because the build folders are equally deep: paths in them are relative.
# Precompiled headers are for builds without ccache, which does not know them well.
PRECOMPILE=ON
use_ccache() {
  command -v ccache >/dev/null || return 0
  PRECOMPILE=OFF
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CCACHE_DIR=${CCACHE_DIR:-$BUILD/ccache} CCACHE_BASEDIR=$ROOT CCACHE_NOHASHDIR=1
}

# configure FOLDER OPTION...: sets up a build in a folder of .build
configure() {
  local folder=$BUILD/$1
  shift
  use_ccache
  cmake -S "$ROOT" -B "$folder" -DPYTHON_EXECUTABLE=/usr/bin/python3 \
    -DKESTREL_PRECOMPILE_HEADERS="$PRECOMPILE" "$@"
}

# build FOLDER TARGET...: builds the targets, all where none is named
build() {
  local folder=$BUILD/$1
  shift
  cmake --build "$folder" -j "$(job_count)" ${1:+--target "$@"}
}

# build_workspace on|off TARGET...: builds the package for ROS as catkin does, with or without the
# tests that need ROS, and installs it into .build/ws/install where a target is `install`.
build_workspace() {
  local tests=$1
  shift
  configure ros -DCMAKE_BUILD_TYPE=Release -DKESTREL_WITH_ROS=ON -DKESTREL_WERROR=ON \
    -DKESTREL_BUILD_BENCHMARKS=OFF -DKESTREL_BUILD_TESTS="$tests" -DKESTREL_ONLY_ROS_TESTS=ON \
    -DCATKIN_ENABLE_TESTING="$tests" -DCATKIN_DEVEL_PREFIX="$WORKSPACE/devel" \
    -DCMAKE_INSTALL_PREFIX="$WORKSPACE/install" && build ros "$@"
}

# Reads the output of make or ctest, and prints how far it is whenever 10 s have passed:
# `   45% kestrel_map (2:10 min)`.
progress() {
  local line state="" begin=$SECONDS last=$SECONDS
  local make_line='^\[ *([0-9]+%)\] .*(CMakeFiles/|Built target )([A-Za-z0-9_]+)'
  local ctest_line='^ *([0-9]+/[0-9]+) Test +#[0-9]+: ([^ ]+)'
  while true; do
    if IFS= read -r -t 5 line; then
      if [[ $line =~ $make_line ]]; then
        state="${BASH_REMATCH[1]} ${BASH_REMATCH[3]}"
      elif [[ $line =~ $ctest_line ]]; then
        state="${BASH_REMATCH[1]} ${BASH_REMATCH[2]}"
      fi
    elif [ $? -le 128 ]; then
      return 0 # the end; above 128 it was only the time limit of read
    fi
    if ((SECONDS - last >= 10)); then
      last=$SECONDS
      printf '   %s (%d:%02d min)\n' "${state:-working}" $(((last - begin) / 60)) \
        $(((last - begin) % 60))
    fi
  done
}

# heartbeat LOG COMMAND...: runs a command with its output in LOG. Whenever 10 s have passed, prints
# the last line of the log, so that everybody sees that it works.
heartbeat() {
  local log=$1 begin=$SECONDS worker
  shift
  "$@" >"$log" 2>&1 &
  worker=$!
  while kill -0 "$worker" 2>/dev/null; do
    sleep 1
    if (((SECONDS - begin) % 10 == 9)); then
      printf '   %s (%d:%02d min)\n' "$(tail -n 1 "$log" | tr -d '\r' | cut -c -60)" \
        $(((SECONDS - begin) / 60)) $(((SECONDS - begin) % 60))
    fi
  done
  wait "$worker"
}

# build_or_die TARGET...: builds the package for ROS without its tests, and shows how far it is.
build_or_die() {
  local log=$BUILD/build.log
  mkdir -p "$BUILD"
  say "building (log: $log)"
  if ! build_workspace OFF "$@" 2>&1 | tee "$log" | progress; then
    { grep -E -A 5 'error:|Error [0-9]' "$log" || tail -n 40 "$log"; } | head -n 60 >&2
    die "the build failed, see above and $log"
  fi
}

# print_table SCRIPT FOLDER TARGETS OPTION...: builds the programs for a table of results and prints
# it. TARGETS: those of the core, in one word; `ros`: the whole package, whose programs read bags.
# With --build DIR or --list among the options, nothing is built.
print_table() {
  local script=$1 folder=$2 targets=$3 programs=$BUILD/core
  shift 3
  [ "$targets" != ros ] || programs=$WORKSPACE/install/lib/kestrel_slam
  case " $* " in
  *" --list "* | *" --build "*) ;;
  *)
    if [ "$targets" = ros ]; then
      "$ROOT/scripts/build" >&2
    else
      build_targets "$targets"
    fi
    ;;
  esac
  exec /usr/bin/python3 "$ROOT/scripts/$script" --build "$programs" \
    --data "${KESTREL_DATA:-$ROOT/../shared/data}" --output "$ROOT/out/$folder" "$@"
}

# build_targets TARGETS: builds programs of the core, without ROS.
build_targets() {
  "$ROOT/scripts/setup" --tests >&2
  say "building" >&2
  mkdir -p "$BUILD/log"
  # shellcheck disable=SC2086
  { cmake -S "$ROOT" -B "$BUILD/core" -DKESTREL_WITH_ROS=OFF -DCMAKE_BUILD_TYPE=Release &&
    cmake --build "$BUILD/core" -j "$(job_count)" --target $1; } \
    >"$BUILD/log/benchmark_build.log" 2>&1 ||
    { tail -n 30 "$BUILD/log/benchmark_build.log"; exit 1; }
}

# Enters the environment of the installed package and adds its tools to PATH. It does not use
# `devel`, because rosrun would then search the clone and find the programs in .build twice.
enter_workspace() {
  local setup=$WORKSPACE/install/setup.bash
  [ -f "$setup" ] || die "$setup is missing: run scripts/build"
  set +u
  # shellcheck disable=SC1090
  source "$setup"
  set -u
  export PATH="/usr/bin:$WORKSPACE/install/lib/kestrel_slam:$PATH"
  # ROS writes its logs to the home folder. Some accounts have none.
  [ -w "${ROS_HOME:-${HOME:-/nowhere}}" ] || export ROS_HOME=$BUILD/ros_home
}
