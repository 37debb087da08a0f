#include "db/export/bus_log.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "control/bus/candump_log.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using contract::BusRecord;

constexpr std::size_t kLinesPerPiece = 1024;
constexpr std::uint64_t kTick_ns = 10'000'000, kEnd_ns = ~std::uint64_t{0};
// linux/can/error.h: CAN_ERR_CRTL, and CAN_ERR_CRTL_RX_OVERFLOW in data[1].
constexpr std::uint32_t kControllerError = 0x00000004U;
constexpr std::uint64_t kReceiveOverflow = 0x0100;

}  // namespace

BusLog::BusLog(Database& database, const SessionInfo& info) : reader_(database), info_(info) {
  Statement end(database.handle(), "SELECT coalesce(max(first_frame + frames), 0) FROM bus_chunks WHERE session_id = ?1");
  if (end.integer(1, info.id).step()) end_frame_ = end.unsigned_at(0);
  // Steps follow the clock also where some were left out, so any stored one says when another was.
  std::uint64_t tick = 0, time_ns = info.start_time_ns;
  Statement sample(database.handle(), "SELECT first_tick, first_time_ns FROM chunks WHERE session_id = ?1 ORDER BY first_tick LIMIT 1");
  if (sample.integer(1, info.id).step()) {
    tick = sample.unsigned_at(0);
    time_ns = sample.unsigned_at(1);
  }
  const auto time_of = [tick, time_ns](std::uint64_t other) {
    if (other >= tick) return time_ns + (other - tick) * kTick_ns;
    return time_ns - std::min(time_ns, (tick - other) * kTick_ns);
  };
  const Result<std::vector<Gap>> gaps = reader_.gaps(info.id);
  if (!gaps) throw SqlFailure{gaps.error()};
  for (const Gap& gap : *gaps)
    // Half a step early: steps and frames jitter, and nothing is recorded inside the gap.
    if (gap.stream == "bus") holes_.push_back({time_of(gap.from_tick), time_of(gap.to_tick) - kTick_ns / 2});
  std::ranges::sort(holes_, {}, &Hole::from_ns);
}

void BusLog::line(std::string& out, const BusRecord& record) {
  const std::int64_t since_ns = static_cast<std::int64_t>(record.time_ns) - static_cast<std::int64_t>(info_.start_time_ns);
  bus::LogEntry entry;
  entry.time_us = static_cast<std::uint64_t>(std::max<std::int64_t>(0, info_.started_utc_ns + since_ns)) / 1000;
  entry.frame = {record.id, record.dlc, record.flags, std::bit_cast<decltype(entry.frame.data)>(record.data)};
  std::string_view(info_.simulated ? "vcan0" : "can0").copy(entry.interface.data(), entry.interface.size() - 1);
  const bool error = (record.flags & contract::CanFrame::kError) != 0;
  entry.direction = error ? bus::Direction::unknown : record.sent != 0 ? bus::Direction::sent : bus::Direction::received;
  std::array<char, bus::kLogLineMax> text;
  const std::size_t length = bus::format_log_line(entry, text);
  if (length == 0)
    throw SqlFailure{Error{ErrorKind::corrupt, "session " + std::to_string(info_.id) + " holds a bus frame that cannot exist", {}}};
  out.append(text.data(), length);
  last_time_ns_ = std::max(last_time_ns_, record.time_ns);
}

// The gaps that end before this moment: they stand between the last frame before and the first one after.
void BusLog::holes_before(std::string& out, std::uint64_t time_ns) {
  for (; next_hole_ < holes_.size() && holes_[next_hole_].to_ns <= time_ns; ++next_hole_) {
    BusRecord lost;
    lost.time_ns = std::min(std::max(last_time_ns_, holes_[next_hole_].from_ns), time_ns);
    lost.id = kControllerError;
    lost.flags = contract::CanFrame::kError;
    lost.dlc = 8;
    lost.data = kReceiveOverflow;
    line(out, lost);
  }
}

bool BusLog::next(std::string& out) {
  if (at_ == frames_.size()) {
    next_frame_ += frames_.size();
    frames_.clear();
    at_ = 0;
    if (next_frame_ < end_frame_) {
      Result<std::vector<BusRecord>> chunk = reader_.bus_chunk(info_.id, next_frame_);
      if (!chunk) throw SqlFailure{chunk.error()};
      frames_ = std::move(*chunk);
      frames_.resize(std::min<std::size_t>(frames_.size(), end_frame_ - next_frame_));
    }
    if (frames_.empty()) {
      holes_before(out, kEnd_ns);
      return !out.empty();
    }
  }
  for (std::size_t lines = 0; lines < kLinesPerPiece && at_ < frames_.size(); ++lines, ++at_) {
    holes_before(out, frames_[at_].time_ns);
    line(out, frames_[at_]);
  }
  return true;
}

std::unique_ptr<FormatWriter> make_candump(ExportSource& source) { return std::make_unique<BusLog>(source.database, source.info); }

}  // namespace hoist::db
