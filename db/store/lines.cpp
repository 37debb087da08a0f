#include "db/store/lines.hpp"

#include <nlohmann/json.hpp>

#include "db/store/exercise_json.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using contract::Exercise;
using contract::ExerciseShape;
using nlohmann::json;

constexpr const char* kLineRows = "SELECT id, name, version, saved_utc_ns, exercise FROM lines WHERE ";

LineInfo line_at(const Statement& row) {
  LineInfo info{.id = row.integer_at(0),
                .name = row.text_at(1),
                .version = row.integer_at(2),
                .saved_utc_ns = row.integer_at(3),
                .exercise = {},
                .tag = {}};
  std::vector<ExerciseProblem> problems;
  const auto exercise = read_exercise(json::parse(row.text_at(4), nullptr, false), ExerciseNames::stored, problems);
  if (!exercise || exercise->shape != ExerciseShape::own)
    throw SqlFailure{Error{ErrorKind::corrupt, "the own line " + std::to_string(info.id) + " cannot be read", {}}};
  info.exercise = *exercise;
  info.tag = edit_tag({info.name, std::to_string(info.version)});
  return info;
}

std::optional<LineInfo> line_row(sqlite3* handle, std::int64_t line) {
  Statement row(handle, std::string(kLineRows) + "id = ?1");
  return row.integer(1, line).step() ? std::optional(line_at(row)) : std::nullopt;
}

Error no_such_line(std::int64_t line) { return {ErrorKind::not_found, "there is no own line " + std::to_string(line), {}}; }

bool line_name_used(sqlite3* handle, const std::string& name, std::int64_t but_of) {
  Statement row(handle, "SELECT 1 FROM lines WHERE name = ?1 AND id <> ?2");
  return row.text(1, std::string_view(name)).integer(2, but_of).step();
}
Error line_name_taken() { return {ErrorKind::taken, "there is a line of this name already", "name"}; }

std::string stored_line(const Exercise& exercise) { return exercise_json(exercise, ExerciseNames::stored).dump(); }
Status check_own(const Exercise& exercise) {
  if (exercise.shape == ExerciseShape::own && contract::figure_of(exercise).valid()) return {};
  return Error{ErrorKind::bad_value, "must be an own line", "exercise.shape"};
}

}  // namespace

Status check_line_name(const std::string& name) {
  if (name.empty() || !is_plain_line(name, kMaxLineName_bytes))
    return Error{ErrorKind::bad_value, "must be one line of 1 to 64 bytes", "name"};
  return {};
}

Result<VisitPage<LineInfo>> LineStore::list(const VisitQuery& query) const {
  return guarded([&]() -> Result<VisitPage<LineInfo>> {
    Statement rows(database_->handle(), std::string(kLineRows) + "id < ?1 ORDER BY id DESC LIMIT ?2");
    return page_of<LineInfo>(rows, query, line_at, [](const LineInfo& line) { return line.id; });
  });
}

Result<LineInfo> LineStore::get(std::int64_t line) const {
  return guarded([&]() -> Result<LineInfo> {
    const auto found = line_row(database_->handle(), line);
    return found ? Result<LineInfo>(*found) : no_such_line(line);
  });
}

Result<LineInfo> LineStore::create(const std::string& name, const Exercise& exercise, std::int64_t utc_ns) {
  if (Status checked = check_line_name(name); !checked) return checked.error();
  if (Status checked = check_own(exercise); !checked) return checked.error();
  return guarded([&]() -> Result<LineInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    if (line_name_used(handle, name, 0)) return line_name_taken();
    {
      Statement count(handle, "SELECT count(*) FROM lines");
      count.step();
      if (count.unsigned_at(0) >= kMaxLines)
        return Error{ErrorKind::wrong_state, "a hoist has at most " + std::to_string(kMaxLines) + " own lines", {}};
    }
    const std::string text = stored_line(exercise);
    std::int64_t id = 0;
    {
      Statement row(handle, "INSERT INTO lines (name, version, saved_utc_ns, exercise) VALUES (?1, 1, ?2, ?3) RETURNING id");
      row.text(1, std::string_view(name)).integer(2, utc_ns).text(3, std::string_view(text)).step();
      id = row.integer_at(0);
    }
    LineInfo made = line_row(handle, id).value();
    transaction.commit();
    return made;
  });
}

Result<LineInfo> LineStore::change(std::int64_t line, const LinePatch& patch, std::int64_t utc_ns, const std::string& expected) {
  if (patch.name)
    if (Status checked = check_line_name(*patch.name); !checked) return checked.error();
  if (patch.exercise)
    if (Status checked = check_own(*patch.exercise); !checked) return checked.error();
  return guarded([&]() -> Result<LineInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    const auto row = line_row(handle, line);
    if (!row) return no_such_line(line);
    if (Status same = check_tag(expected, row->tag); !same) return same.error();
    const std::string name = patch.name.value_or(row->name), text = stored_line(patch.exercise.value_or(row->exercise));
    if (line_name_used(handle, name, line)) return line_name_taken();
    Statement(handle, "UPDATE lines SET name = ?2, version = version + 1, saved_utc_ns = ?3, exercise = ?4 WHERE id = ?1")
        .integer(1, line)
        .text(2, std::string_view(name))
        .integer(3, utc_ns)
        .text(4, std::string_view(text))
        .run();
    LineInfo changed = line_row(handle, line).value();
    transaction.commit();
    return changed;
  });
}

Status LineStore::remove(std::int64_t line, const std::string& expected) {
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    const auto row = line_row(handle, line);
    if (!row) return no_such_line(line);
    if (Status same = check_tag(expected, row->tag); !same) return same;
    Statement(handle, "DELETE FROM lines WHERE id = ?1").integer(1, line).run();
    transaction.commit();
    return {};
  });
}

}  // namespace hoist::db
