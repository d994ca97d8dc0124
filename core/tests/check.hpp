// Checks that print what failed and where. A test program ends with `return verdict();`
#pragma once

#include <cmath>
#include <cstdio>
#include <cstring>

namespace multilift {

inline int& failures() {
  static int count = 0;
  return count;
}

inline void fail(const char* file, int line, const char* what) {
  std::printf("%s:%d: %s\n", file, line, what);
  ++failures();
}

inline void check_close(const char* file, int line, const char* what, double found, double expected,
                        double tolerance) {
  // False for NaN, so that NaN fails.
  if (std::fabs(found - expected) <= tolerance) return;
  fail(file, line, what);
  std::printf("  found %.17g, expected %.17g within %.3g\n", found, expected, tolerance);
}

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// The exit status of a test program.
inline int verdict() { return failures() == 0 ? 0 : 1; }

}  // namespace multilift

#define CHECK(condition)                                                         \
  do {                                                                           \
    if (!(condition)) ::multilift::fail(__FILE__, __LINE__, "not: " #condition); \
  } while (false)

#define CHECK_CLOSE(found, expected, tolerance) \
  ::multilift::check_close(__FILE__, __LINE__, #found, (found), (expected), (tolerance))
