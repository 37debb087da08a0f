// House rules checked by a program: allowed includes, forbidden words of the pure parts, forbidden content. Each rule is a function of file
// names and texts, so that tests can run it on small bad files.
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
  int line = 0;  // 1 is the first; 0 means the file
  std::string rule;
  std::string what;
};

// The same text with comments, string and character literals blanked, line breaks kept. With keep_strings the literals stay (for include
// lines and messages).
std::string without_comments(std::string_view text, bool keep_strings);

// The rules of one file. `all_paths` are the sorted paths of the tree: an include must name one of them.
std::vector<Finding> check_file(const File& file, const std::vector<std::string>& all_paths);

// Circles among the rooms (files; a header with its source is one) and folders of each folder. An arrow is an include or an import.
std::vector<Finding> check_circles(const std::vector<File>& files);

// The rules of the whole tree: circles, top-level entries, README of each area, executable bits, sources outside the build.
std::vector<Finding> check_tree(const std::vector<File>& files);

}  // namespace hoist::tidy
