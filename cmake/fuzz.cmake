# SPDX-License-Identifier: BSD-3-Clause
# One libFuzzer program for each test/fuzz/*_fuzzer.cpp: fuzz_<name>. Needs clang. The libraries are
# built with coverage and sanitizers too (scripts/test --fuzz). Without KESTREL_FUZZ the fuzzers are
# part of test_fuzz, which runs them on the files of test/fuzz/corpus.
file(GLOB FUZZERS CONFIGURE_DEPENDS test/fuzz/*_fuzzer.cpp)
if(NOT KESTREL_WITH_ROS)
  list(FILTER FUZZERS EXCLUDE REGEX "/bag_[a-z_]*\\.cpp$")
endif()
add_custom_target(fuzzers)
foreach(source ${FUZZERS})
  get_filename_component(name ${source} NAME_WE)
  string(REGEX REPLACE "_fuzzer$" "" name ${name})
  add_executable(fuzz_${name} EXCLUDE_FROM_ALL ${source})
  target_include_directories(fuzz_${name} PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_compile_definitions(fuzz_${name} PRIVATE KESTREL_FUZZ)
  target_link_libraries(fuzz_${name} PRIVATE kestrel_evaluation kestrel_graph kestrel_parameters kestrel_warnings)
  target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzzers fuzz_${name})
endforeach()
