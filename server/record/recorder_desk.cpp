#include "server/record/recorder_desk.hpp"

#include <exception>

namespace hoist::server {

bool RecorderDesk::ask_any(std::function<std::any(Records&)> work, Continuation then) {
  const std::uint64_t ticket = ++last_ticket_;
  waiting_.emplace(ticket, std::move(then));
  const bool taken = recorder_.run([this, ticket, work = std::move(work)](Records& records) {
    std::any result;
    try {
      result = work(records);
    } catch (const std::exception&) {
      // An empty result says so: no `work` returns one.
    }
    post_([this, ticket, result = std::move(result)]() mutable { answer(ticket, result); });
  });
  if (!taken) waiting_.erase(ticket);
  return taken;
}

void RecorderDesk::answer(std::uint64_t ticket, std::any& result) {
  // Taken out first: `then` may ask for the next thing.
  const auto waiting = waiting_.extract(ticket);
  if (!waiting.empty() && result.has_value()) waiting.mapped()(result);
}

RecorderDesk::ExportHandle RecorderDesk::hold(ExportId id) {
  return {new ExportId(id), [this](const ExportId* held) {
            recorder_.close_export(*held);
            delete held;
          }};
}

}  // namespace hoist::server
