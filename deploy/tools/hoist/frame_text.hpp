// One frame of the bus as a line of text or of JSON: recordings and the live monitor print alike.
#pragma once

#include "control/bus/candump_log.hpp"
#include "control/bus/decode.hpp"

namespace hoist::tool {

void print_frame_text(double time_s, const bus::LogEntry& entry, const bus::DecodedFrame& frame);
void print_frame_json(double time_s, const bus::LogEntry& entry, const bus::DecodedFrame& frame);

}  // namespace hoist::tool
