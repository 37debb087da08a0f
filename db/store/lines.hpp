// Own lines: what therapists have drawn on the floor, by name, for all patients of this hoist.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "control/contract/exercises.hpp"
#include "db/store/database.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/page.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

inline constexpr std::size_t kMaxLineName_bytes = 64;
/// Of one hoist; more are refused.
inline constexpr std::size_t kMaxLines = 100;

struct LineInfo {
  std::int64_t id = 0;
  std::string name;
  std::int64_t version = 0;  ///< counts the savings
  std::int64_t saved_utc_ns = 0;
  contract::Exercise exercise;  ///< of the shape own
  std::string tag;
};
struct LinePatch {
  std::optional<std::string> name;
  std::optional<contract::Exercise> exercise;
};

/// One line of 1 to 64 bytes; otherwise bad_value, field name.
Status check_line_name(const std::string& name);

/// Errors: not_found, changed, taken (name), bad_value, wrong_state (too many), corrupt, busy, disk_full.
class LineStore {
 public:
  explicit LineStore(Database& database) : database_(&database) {}
  /// Newest first.
  Result<VisitPage<LineInfo>> list(const VisitQuery& query) const;
  Result<LineInfo> get(std::int64_t line) const;
  Result<LineInfo> create(const std::string& name, const contract::Exercise& exercise, std::int64_t utc_ns);
  Result<LineInfo> change(std::int64_t line, const LinePatch& patch, std::int64_t utc_ns, const std::string& expected);
  Status remove(std::int64_t line, const std::string& expected);

 private:
  Database* database_;
};

}  // namespace hoist::db
