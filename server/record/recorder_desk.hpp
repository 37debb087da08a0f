// The network thread's way to the database (threads/answer_desk.hpp says what may cross).
#pragma once
#include <functional>
#include <memory>
#include <utility>

#include "server/record/recorder.hpp"
#include "server/threads/answer_desk.hpp"

namespace hoist::server {

class RecorderDesk : public AnswerDesk<Records> {
 public:
  RecorderDesk(Recorder& recorder, Post post)
      : AnswerDesk([&recorder](std::function<void(Records&)> work) { return recorder.run(std::move(work)); }, std::move(post)),
        recorder_(recorder) {}

  // An export that lives on the recorder's thread, held from here: it is closed when the last copy of the handle goes.
  using ExportHandle = std::shared_ptr<const ExportId>;
  [[nodiscard]] ExportHandle hold(ExportId id) {
    return {new ExportId(id), [this](const ExportId* held) {
              recorder_.close_export(*held);
              delete held;
            }};
  }

 private:
  Recorder& recorder_;
};

}  // namespace hoist::server
