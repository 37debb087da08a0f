#include <filesystem>
#include <functional>
#include <map>
#include <regex>
#include <set>

#include "tests/tidy/rules.hpp"

namespace hoist::tidy {
namespace {

using Arrows = std::map<std::string, std::set<std::string>>;

std::string room_of(const std::string& path) { return std::regex_replace(path, std::regex(R"(\.(cpp|hpp|h|cc|tsx?)$)"), ""); }

// Rooms that this file names, of those in `rooms`.
std::set<std::string> rooms_named(const File& file, const std::set<std::string>& rooms) {
  static const std::regex include(R"x(^\s*#\s*include\s*"([^"]+)")x");
  static const std::regex imports(R"x((?:from|import)\s*\(?\s*['"](\.\.?/[^'"]*)['"])x");
  const bool web = file.path.rfind("web/", 0) == 0;
  const std::string text = web ? file.text : without_comments(file.text, true);
  std::set<std::string> named;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    std::smatch match;
    if (!std::regex_search(line, match, web ? imports : include)) continue;
    const auto full = web ? std::filesystem::path(file.path).parent_path() / match[1].str() : std::filesystem::path(match[1].str());
    const std::string room = room_of(full.lexically_normal().string());
    if (rooms.count(room) != 0) named.insert(room);
  }
  return named;
}

// "a -> b -> a", or nothing.
std::string circle_in(const Arrows& arrows) {
  std::map<std::string, int> seen;  // 1: on the way, 2: done
  std::vector<std::string> way;
  const std::function<std::string(const std::string&)> walk = [&](const std::string& from) -> std::string {
    seen[from] = 1;
    way.push_back(from);
    if (const auto row = arrows.find(from); row != arrows.end()) {
      for (const std::string& to : row->second) {
        if (seen[to] == 2) continue;
        if (seen[to] == 0) {
          if (const std::string found = walk(to); !found.empty()) return found;
          continue;
        }
        std::string told = to;
        for (auto back = way.rbegin(); *back != to; ++back) told = *back + " -> " + told;
        return to + " -> " + told;
      }
    }
    way.pop_back();
    seen[from] = 2;
    return {};
  };
  for (const auto& [from, to] : arrows)
    if (seen[from] == 0)
      if (const std::string found = walk(from); !found.empty()) return found;
  return {};
}

}  // namespace

std::vector<Finding> check_circles(const std::vector<File>& files) {
  static const std::regex source(R"(\.(cpp|hpp|h|cc|def|tsx?)$)");
  std::set<std::string> rooms;
  for (const File& file : files)
    if (std::regex_search(file.path, source)) rooms.insert(room_of(file.path));
  std::map<std::string, Arrows> folders;  // of each folder: arrows between its rooms and folders
  for (const File& file : files) {
    if (!std::regex_search(file.path, source)) continue;
    const std::string from = room_of(file.path);
    for (const std::string& to : rooms_named(file, rooms)) {
      if (to == from) continue;
      std::size_t common = 0;  // behind the last folder that both are in
      for (std::size_t at = 0; at < std::min(from.size(), to.size()) && from[at] == to[at]; ++at)
        if (from[at] == '/') common = at + 1;
      const auto next = [&](const std::string& path) {  // a folder with its stroke: a file may have its name
        const std::size_t stroke = path.find('/', common);
        return stroke == std::string::npos ? path.substr(common) : path.substr(common, stroke + 1 - common);
      };
      folders[from.substr(0, common)][next(from)].insert(next(to));
    }
  }
  std::vector<Finding> findings;
  for (const auto& [folder, arrows] : folders)
    if (const std::string circle = circle_in(arrows); !circle.empty()) findings.push_back({folder, 0, "circle", circle});
  return findings;
}

}  // namespace hoist::tidy
