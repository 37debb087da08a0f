// What a client may change in what is stored: a session's texts, markers, the hoist's own name and language; and the clock. A change carries the
// tag of what it was made for (db/store/edit_tag.hpp); empty = any.
#pragma once
#include <cstdint>
#include <string>

#include "db/store/device_settings.hpp"
#include "db/store/markers.hpp"
#include "db/store/session_reader.hpp"
#include "server/actions/actions.hpp"

namespace hoist::server {

void act_change_session(Services& services, const Asker& asker, db::SessionId session, db::SessionPatch patch, std::string tag,
                        OutcomeDone done);
struct MarkerPlace {
  db::SessionId session = 0;
  std::int64_t number = 0;
};
// `Outcome::row` is the marker afterwards.
void act_change_marker(Services& services, const Asker& asker, const MarkerPlace& place, db::MarkerPatch patch, std::string tag,
                       OutcomeDone done);
void act_delete_marker(Services& services, const Asker& asker, const MarkerPlace& place, std::string tag, OutcomeDone done);
// Name and language of the hoist.
void act_change_device(Services& services, const Asker& asker, db::DeviceSettingsPatch patch, std::string tag, OutcomeDone done);
// Refused where the operating system keeps the time (Settings::set_clock), while a session is recorded and while the hoist is led: a jump of the
// clock would tear the recording's times apart.
void act_set_clock(Services& services, const Asker& asker, std::int64_t utc_ms, OutcomeDone done);

}  // namespace hoist::server
