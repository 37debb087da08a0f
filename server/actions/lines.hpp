// What a client may do with own lines. A change carries the tag of what it was made for (db/store/edit_tag.hpp); empty = any state.
// `Outcome::row` is the row as it is afterwards.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/actions/actions.hpp"

namespace hoist::server {

struct LineWish {
  std::optional<std::string> name;
  const nlohmann::json& exercise;  // null: as it is
};
void act_create_line(Services& services, const Asker& asker, const LineWish& wish, OutcomeDone done);
void act_change_line(Services& services, const Asker& asker, std::int64_t line, const LineWish& wish, std::string tag, OutcomeDone done);
void act_delete_line(Services& services, const Asker& asker, std::int64_t line, std::string tag, OutcomeDone done);

}  // namespace hoist::server
