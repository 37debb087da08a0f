// The house rules that a program can check: who may include whom, what the pure parts may not use, what no file may hold.
// Each rule is a function of file names and texts, so that the tests can show it small bad files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hoist::tidy {

struct File {
  std::string path;  // from the tree top, with '/'
  std::string text;
  bool runnable = false;
};

struct Finding {
  std::string path;
  int line = 0;  // 1 is the first; 0 is the file as a whole
  std::string rule;
  std::string what;
};

// The same text with comments, string and character literals blanked, line breaks kept: what is left is code.
// With keep_strings the literals stay (include lines and messages live in them).
std::string without_comments(std::string_view text, bool keep_strings);

// The rules of one file. `all_paths` are the paths of the whole tree, sorted: an include must name one of them.
std::vector<Finding> check_file(const File& file, const std::vector<std::string>& all_paths);

// The rules of the tree as a whole: top-level entries, README of each area, run bits, sources that no build knows.
std::vector<Finding> check_tree(const std::vector<File>& files);

}  // namespace hoist::tidy
