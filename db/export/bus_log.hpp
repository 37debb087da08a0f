// The recorded CAN frames of a session in candump's log format (control/bus/candump_log.hpp), piece by piece.
//
// Times are the session's start by the wall clock plus steady time: a clock that is set meanwhile does not move them. The interface is "can0",
// of a simulated hoist "vcan0". R and T say whether the control computer received or sent a frame. The format has no comments; where frames
// are missing stands the error frame with which SocketCAN reports a receive overflow: 20000004#0001000000000000.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/commands.hpp"
#include "db/export/source.hpp"

namespace hoist::db {

class BusLog : public FormatWriter {
 public:
  /// Inside a read transaction: what is recorded later does not belong to it.
  BusLog(Database& database, const SessionInfo& info);
  bool next(std::string& out) override;

 private:
  struct Hole {
    std::uint64_t from_ns = 0, to_ns = 0;
  };
  void line(std::string& out, const contract::BusRecord& record);
  void holes_before(std::string& out, std::uint64_t time_ns);

  SessionReader reader_;
  SessionInfo info_;
  std::uint64_t next_frame_ = 0, end_frame_ = 0, last_time_ns_ = 0;
  std::vector<contract::BusRecord> frames_;  // of the stored chunk under way
  std::size_t at_ = 0;
  std::vector<Hole> holes_;  // by their begin
  std::size_t next_hole_ = 0;
};

}  // namespace hoist::db
