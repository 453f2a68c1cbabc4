# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# The part of scripts/test --sanitize; sourced there.

SANITIZED="-O1 -g1 -fno-omit-frame-pointer"

# Without NDEBUG: the assertions of Eigen find accesses outside of matrices. Without -Werror: the
# instrumented code makes gcc warn of variables that it does not see initialized.
build_asan() {
  configure asan -DKESTREL_WITH_ROS=OFF -DKESTREL_BUILD_BENCHMARKS=OFF \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="$SANITIZED \
    -fsanitize=address,undefined -fno-sanitize-recover=all" && build asan
}

test_asan() {
  say "core with AddressSanitizer and UndefinedBehaviorSanitizer"
  step "asan: build" build_asan || return 0
  export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
  export UBSAN_OPTIONS=print_stacktrace=1
  suites asan asan
}

build_tsan() {
  configure tsan -DKESTREL_WITH_ROS=ON -DKESTREL_BUILD_BENCHMARKS=OFF \
    -DKESTREL_ONLY_ROS_TESTS=ON -DCATKIN_ENABLE_TESTING=ON \
    -DCATKIN_DEVEL_PREFIX="$BUILD/tsan/devel" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="$SANITIZED -fsanitize=thread" && build tsan
}

# Every process with a finding leaves a file PREFIX.<process>.
no_findings() {
  local files
  files=$(compgen -G "$1.*" || true)
  [ -n "$files" ] || return 0
  cat "$1".*
  printf '%d findings\n' "$(cat "$1".* | grep -c 'WARNING: ThreadSanitizer')"
  return 1
}

test_tsan() {
  say "live nodes with ThreadSanitizer"
  step "tsan: build" build_tsan || return 0
  local reports=$LOGS/tsan_report
  rm -f "$reports".*
  export TSAN_OPTIONS="log_path=$reports exitcode=0"
  suites tsan tsan -R rostest_test_ros
  step "tsan: no findings" no_findings "$reports" || true
}
