#include "server/state/notices.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include "server/contract/notices.hpp"

namespace hoist::server {

namespace {
std::string store_detail(contract::StoreProblem problem) {
  switch (problem) {
    case contract::StoreProblem::no_file:
      return "hoist-control was started without --params FILE.";
    case contract::StoreProblem::disk_full:
      return "The disk of the settings is full.";
    case contract::StoreProblem::failed:
    case contract::StoreProblem::none:
      break;
  }
  return "The disk of the settings does not answer or reports an error.";
}

std::string filled(std::string_view text, int percent) {
  constexpr std::string_view kPlace = "{percent}";
  std::string out{text};
  if (const std::size_t at = out.find(kPlace); at != std::string::npos) out.replace(at, kPlace.size(), std::to_string(percent));
  return out;
}
}  // namespace

std::vector<StandingNotice> standing_notices(const CoreDesk& core, const Recorder& recorder, const Jobs& jobs, const PeopleDesk& people) {
  std::vector<StandingNotice> notices;
  if (const auto problem = core.store_problem()) notices.push_back({NoticeName::settings_not_stored, store_detail(*problem)});
  if (const auto problem = core.stops_problem()) notices.push_back({NoticeName::stops_not_stored, store_detail(*problem)});
  if (const auto percent = core.slow_time_percent())
    notices.push_back({NoticeName::simulation_slow, "Simulated time over the last 2 s, in percent of real time.", *percent});
  const RecordingStatus recording = recorder.status();
  notices.insert(notices.end(), recording.notices.begin(), recording.notices.end());
  if (const FileHealth file = jobs.file_health(); file.state == FileState::damaged)
    notices.push_back({NoticeName::recordings_damaged, file.detail});
  if (std::string why = people.not_stored(); !why.empty()) notices.push_back({NoticeName::accounts_not_stored, std::move(why)});
  return notices;
}

nlohmann::json notices_json(const std::vector<StandingNotice>& notices) {
  nlohmann::json items = nlohmann::json::array();
  for (const StandingNotice& notice : notices) {
    const NoticeInfo& info = kNotices[static_cast<std::size_t>(notice.name)];
    items.push_back({{"name", info.name},
                     {"priority", info.priority},
                     {"text", {{"en", filled(info.text_en, notice.percent)}, {"de", filled(info.text_de, notice.percent)}}},
                     {"action", {{"en", info.action_en}, {"de", info.action_de}}},
                     {"detail", notice.detail}});
  }
  return items;
}

}  // namespace hoist::server
