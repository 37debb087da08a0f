// hoist-reactions [FILE]: measures every reaction, prints the page and writes it to FILE.
#include <cstdio>
#include <fstream>

#include "tests/reactions/reactions.hpp"

int main(int count, char** arguments) {
  if (count > 2 || (count == 2 && arguments[1][0] == '-')) {
    std::fputs("usage: hoist-reactions [FILE]\n  measures every reaction, prints the page and writes it to FILE\n", stderr);
    return 2;
  }
  const auto rows = hoist::reactions::measure(hoist::reactions::kPageTries);
  const std::string text = hoist::reactions::page(rows, hoist::reactions::measure_machines(hoist::reactions::kPageTries));
  std::fputs(text.c_str(), stdout);
  if (count > 1) {
    std::ofstream out(arguments[1], std::ios::binary | std::ios::trunc);
    out << text;
    if (!out.flush()) {
      std::fprintf(stderr, "hoist-reactions: cannot write %s\n", arguments[1]);
      return 2;
    }
  }
  bool fine = true;
  for (const auto& row : rows) {
    if (row.missed == 0 && row.worst_ms <= row.budget_ms) continue;
    fine = false;
    std::fprintf(stderr, "hoist-reactions: %s: %d ms of %d, %d of %d tries without a stop\n", row.fault.c_str(), row.worst_ms,
                 row.budget_ms, row.missed, row.tries);
  }
  return fine ? 0 : 1;
}
