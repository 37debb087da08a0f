#include "server/actions/lines.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "db/store/lines.hpp"
#include "server/actions/common.hpp"
#include "server/state/views.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
Outcome told_line(const db::Result<db::LineInfo>& row) {
  if (!row) return store_outcome(row.error());
  Outcome outcome;
  outcome.row = line_json(*row).dump();
  return outcome;
}

std::string line_target(std::int64_t line) { return "line " + std::to_string(line); }

// The line of a wish; nothing when it is none: `done` has been told.
std::optional<Exercise> wanted_line(const json& told, const OutcomeDone& done) {
  std::vector<FieldError> errors;
  const auto exercise = read_exercise(told, errors);
  if (exercise && exercise->shape != Exercise::Shape::own) errors.push_back({"exercise.shape", "must be own"});
  if (errors.empty()) return exercise;
  Outcome outcome;
  outcome.kind = Outcome::Kind::invalid;
  outcome.reason = Reason::exercise;
  outcome.detail = "The line cannot be used.";
  outcome.errors = std::move(errors);
  done(outcome);
  return std::nullopt;
}
}  // namespace

void act_create_line(Services& services, const Asker& asker, const LineWish& wish, OutcomeDone done) {
  if (!begin_action(services, asker, Action::create_line, {}, done)) return;
  const auto exercise = wanted_line(wish.exercise, done);
  if (!exercise) return;
  const auto work = [name = wish.name.value_or(""), exercise = *exercise, utc_ns = services.utc_ns()](Records&, db::Database& database) {
    return told_line(db::LineStore(database).create(name, exercise, utc_ns));
  };
  ask_store_for(services, work, std::move(done));
}

void act_change_line(Services& services, const Asker& asker, std::int64_t line, const LineWish& wish, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_line, {line_target(line)}, done)) return;
  db::LinePatch patch{.name = wish.name, .exercise = {}};
  if (!wish.exercise.is_null()) {
    patch.exercise = wanted_line(wish.exercise, done);
    if (!patch.exercise) return;
  }
  const auto work = [=, utc_ns = services.utc_ns()](Records&, db::Database& database) {
    return told_line(db::LineStore(database).change(line, patch, utc_ns, tag));
  };
  ask_store_for(services, work, std::move(done));
}

void act_delete_line(Services& services, const Asker& asker, std::int64_t line, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::delete_line, {line_target(line)}, done)) return;
  ask_store(
      services, [=](Records&, db::Database& database) { return db::LineStore(database).remove(line, tag); }, std::move(done));
}

}  // namespace hoist::server
