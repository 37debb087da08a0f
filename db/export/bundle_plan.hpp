// The files that a layout of a bundle consists of; each is made when its turn comes.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "db/export/source.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// One file of a bundle: its name, and what appends its next piece (false at the end; throws SqlFailure).
struct BundleFile {
  std::string name;
  std::int64_t utc_ns = 0;
  bool large = false;  ///< may pass 4 GB
  std::function<std::function<bool(std::string&)>()> open;
};
/// A file whose text is made when its turn comes.
inline BundleFile text_file(std::string name, std::int64_t utc_ns, std::function<std::string()> make) {
  BundleFile file;
  file.name = std::move(name);
  file.utc_ns = utc_ns;
  file.open = [make = std::move(make)] {
    return [make](std::string& out) {
      out += make();
      return false;
    };
  };
  return file;
}

/// Files from a list of sessions. The description of the whole comes first.
class BundlePlan {
 public:
  BundlePlan() = default;
  virtual ~BundlePlan() = default;
  BundlePlan(const BundlePlan&) = delete;
  BundlePlan& operator=(const BundlePlan&) = delete;
  virtual std::vector<BundleFile> first() = 0;
  virtual std::vector<BundleFile> of_session(SessionId session) = 0;
  virtual std::vector<BundleFile> last() = 0;
};

/// Several sessions under way to one file.
class BundleSource : public FormatWriter {
 public:
  /// Share of the work that is done, 0 to 1.
  [[nodiscard]] virtual double progress() const = 0;
};

}  // namespace hoist::db
