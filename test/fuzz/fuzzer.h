// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

// Each *_fuzzer.cpp gives one fuzzer: KESTREL_FUZZER(name, bytes) { ... }, where `bytes` is the
// input, a const std::string&. It must return for every input, and only throw what it catches.
// Built with KESTREL_FUZZ it is a program of libFuzzer, else an entry in fuzzers() for the test
// that runs the corpus.

namespace kestrel::fuzz {

struct Fuzzer {
  std::string name;
  void (*run)(const std::string& bytes);
};

inline std::vector<Fuzzer>& fuzzers() {
  static std::vector<Fuzzer> all;
  return all;
}

struct Registered {
  Registered(const char* name, void (*run)(const std::string&)) {
    fuzzers().push_back({name, run});
  }
};

/// A property that holds for every input. Also checked without assertions.
#define FUZZ_CHECK(condition)                                                          \
  if (!(condition)) {                                                                  \
    std::fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
    std::abort();                                                                      \
  }

#ifdef KESTREL_FUZZ
#define KESTREL_FUZZER(name, bytes)                                                   \
  static void run_##name(const std::string& bytes);                                   \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);  \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    run_##name(std::string(reinterpret_cast<const char*>(data), size));               \
    return 0;                                                                         \
  }                                                                                   \
  static void run_##name(const std::string& bytes)
#else
#define KESTREL_FUZZER(name, bytes)                                               \
  static void run_##name(const std::string& bytes);                               \
  static const ::kestrel::fuzz::Registered registered_##name(#name, &run_##name); \
  static void run_##name(const std::string& bytes)
#endif

}  // namespace kestrel::fuzz
