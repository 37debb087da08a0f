// The figures of a session (db/metrics/metric_list.hpp), from the columns as they are exported.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "db/metrics/metric_list.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// Of what a figure is computed from, by name: a recorded column with the steps it is of, "gaps", "exercise". FNV-1a, 64 bits.
using InputHashes = std::map<std::string, std::uint64_t, std::less<>>;

struct SessionMetrics {
  SessionId session = 0;
  std::string track;   ///< which track was compared: "fused" (encoders and gyroscope, slip repaired) or "encoders" (older sessions)
  std::string shape;   ///< of the exercise; empty without one
  double start_m = 0;  ///< place on the exercise where the walk began
  Figures figures;     ///< in the order of kMetrics
  /// Why there is no C or no J_N.
  NoFigure why_absent = NoFigure::no_exercise;
  InputHashes inputs;  ///< what the figures are computed from

  /// The figure of this key; a key that no figure has is a mistake of the caller and ends the program.
  [[nodiscard]] const Figure& operator[](std::string_view key) const;
};

/// The figures of a session, read in pieces: of a recording of hours the whole takes seconds, and the recorder's thread must go on between two
/// pieces. Holds nothing of the database between them, so the pieces may run on any thread, one after the other. Reads up to nine times; the
/// memory does not grow with the session. Errors: not_found, also when the session was deleted meanwhile; corrupt; io.
class MetricsReading {
 public:
  static Result<MetricsReading> open(Database& database, SessionId session);
  MetricsReading(MetricsReading&&) noexcept;
  MetricsReading& operator=(MetricsReading&&) noexcept;
  ~MetricsReading();
  /// False once take() can be called.
  Result<bool> piece(Database& database);
  SessionMetrics take();
  /// As it was when the reading began.
  [[nodiscard]] const SessionInfo& info() const;

 private:
  struct State;
  explicit MetricsReading(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// All pieces of a reading at once.
template <typename Reading>
auto read_whole(Database& database, Reading& reading) -> Result<decltype(reading.take())> {
  for (;;) {
    const Result<bool> more = reading.piece(database);
    if (!more) return more.error();
    if (!*more) return reading.take();
  }
}

/// In one piece.
Result<SessionMetrics> session_metrics(Database& database, SessionId session);

}  // namespace hoist::db
