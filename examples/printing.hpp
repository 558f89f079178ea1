#pragma once

#include <cstdio>

/// One line with all digits of every number, as the Python examples print them.
template <class Numbers>
void print_numbers(const Numbers& numbers) {
  const char* separator = "";
  for (const double x : numbers) {
    std::printf("%s%.17g", separator, x);
    separator = " ";
  }
  std::printf("\n");
}
