// The network thread's way to a thread of its own. The rule that keeps both apart:
//   - What holds state of the other thread (statements, exports, connections to files) lives and dies there.
//   - What waits for an answer (calls, connections, clients) lives and dies on the network thread.
//   - Only plain values cross: a job's captures and its result.
// So a job never holds a callback. The callback waits here under a number, and only the number travels.
#pragma once
#include <any>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <utility>

namespace hoist::server {

// `Room`: what work on the other thread may use.
template <typename Room>
class AnswerDesk {
 public:
  // `run` takes work for the other thread, or refuses it; `post` runs something on the network thread, from any thread.
  using Run = std::function<bool(std::function<void(Room&)>)>;
  using Post = std::function<void(std::function<void()>)>;
  AnswerDesk(Run run, Post post) : run_(std::move(run)), post_(std::move(post)) {}
  AnswerDesk(const AnswerDesk&) = delete;
  AnswerDesk& operator=(const AnswerDesk&) = delete;

  // `work` runs and is destroyed on the other thread, `then` on this one, with what `work` returned. When `work` throws, `then` is destroyed
  // without being called. False when too many jobs wait: then neither runs.
  template <typename Result>
  [[nodiscard]] bool ask(std::function<Result(Room&)> work, std::function<void(Result)> then) {
    return ask_any([work = std::move(work)](Room& room) { return std::any(work(room)); },
                   [then = std::move(then)](std::any& result) { then(std::move(std::any_cast<Result&>(result))); });
  }

 private:
  using Continuation = std::function<void(std::any&)>;

  bool ask_any(std::function<std::any(Room&)> work, Continuation then) {
    const std::uint64_t ticket = ++last_ticket_;
    waiting_.emplace(ticket, std::move(then));
    const bool taken = run_([this, ticket, work = std::move(work)](Room& room) {
      std::any result;
      try {
        result = work(room);
      } catch (const std::exception&) {
        // An empty result says so: no `work` returns one.
      }
      post_([this, ticket, result = std::move(result)]() mutable { answer(ticket, result); });
    });
    if (!taken) waiting_.erase(ticket);
    return taken;
  }
  void answer(std::uint64_t ticket, std::any& result) {
    // Taken out first: `then` may ask for the next thing.
    const auto waiting = waiting_.extract(ticket);
    if (!waiting.empty() && result.has_value()) waiting.mapped()(result);
  }

  Run run_;
  Post post_;
  std::uint64_t last_ticket_ = 0;
  std::map<std::uint64_t, Continuation> waiting_;
};

}  // namespace hoist::server
