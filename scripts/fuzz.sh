# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# The part of scripts/test --fuzz; sourced there.

FUZZED="-O1 -g1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined \
  -fno-sanitize-recover=undefined"

build_fuzzers() {
  configure fuzz -DKESTREL_WITH_ROS=ON -DKESTREL_FUZZ=ON -DKESTREL_BUILD_TESTS=OFF \
    -DKESTREL_BUILD_BENCHMARKS=OFF -DCMAKE_CXX_COMPILER=clang++ \
    -DCATKIN_DEVEL_PREFIX="$BUILD/fuzz/devel" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="$FUZZED" && build fuzz fuzzers
}

# fuzz NAME: from the corpus in the repository. New inputs stay in the build folder.
fuzz() {
  local program=$BUILD/fuzz/devel/lib/kestrel_slam/fuzz_$1
  mkdir -p "$BUILD/fuzz/corpus/$1" "$LOGS/fuzz"
  "$program" -max_total_time="${KESTREL_FUZZ_SECONDS:-60}" -timeout=20 -rss_limit_mb=2048 \
    -max_len=20000 -print_final_stats=1 -verbosity=0 -artifact_prefix="$LOGS/fuzz/$1-" \
    "$BUILD/fuzz/corpus/$1" "$ROOT/test/fuzz/corpus/$1"
}

test_fuzz() {
  say "fuzzers"
  step "fuzz: build" build_fuzzers || return 0
  local source name
  for source in "$ROOT"/test/fuzz/*_fuzzer.cpp; do
    name=$(basename "$source" _fuzzer.cpp)
    case " ${KESTREL_FUZZERS:-$name} " in *" $name "*) ;; *) continue ;; esac
    step "fuzz: $name" fuzz "$name" || true
  done
}
