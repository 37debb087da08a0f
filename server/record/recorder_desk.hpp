// The network thread's way to the database. The rule that keeps both threads apart:
//   - What holds recorder state (statements, exports, the connection to the file) lives and dies on the recorder's thread.
//   - What waits for an answer (calls, connections, clients) lives and dies on the network thread.
//   - Only plain values cross: a job's captures and its result.
// So a job never holds a callback. The callback waits here under a number, and only the number travels.
#pragma once
#include <any>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "server/record/recorder.hpp"

namespace hoist::server {

class RecorderDesk {
 public:
  // `post` runs something on the network thread; any thread may call it.
  using Post = std::function<void(std::function<void()>)>;
  RecorderDesk(Recorder& recorder, Post post) : recorder_(recorder), post_(std::move(post)) {}
  RecorderDesk(const RecorderDesk&) = delete;
  RecorderDesk& operator=(const RecorderDesk&) = delete;

  // `work` runs and is destroyed on the recorder's thread, `then` on this one, with what `work` returned. When `work` throws, `then` is
  // destroyed without being called. False when too many jobs wait: then neither runs.
  template <typename Result>
  [[nodiscard]] bool ask(std::function<Result(Records&)> work, std::function<void(Result)> then) {
    return ask_any([work = std::move(work)](Records& records) { return std::any(work(records)); },
                   [then = std::move(then)](std::any& result) { then(std::move(std::any_cast<Result&>(result))); });
  }

  // An export that lives on the recorder's thread, held from here: it is closed when the last copy of the handle goes.
  using ExportHandle = std::shared_ptr<const ExportId>;
  [[nodiscard]] ExportHandle hold(ExportId id);

 private:
  using Continuation = std::function<void(std::any&)>;
  bool ask_any(std::function<std::any(Records&)> work, Continuation then);
  void answer(std::uint64_t ticket, std::any& result);

  Recorder& recorder_;
  Post post_;
  std::uint64_t last_ticket_ = 0;
  std::map<std::uint64_t, Continuation> waiting_;
};

}  // namespace hoist::server
