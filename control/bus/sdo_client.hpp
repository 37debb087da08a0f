// Reads and writes objects of a node, for tools (contract/sdo_transfer.hpp).
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/sdo_transfer.hpp"

namespace hoist::bus {

using contract::SdoTiming;
/// Uploads of up to 1 KiB.
using SdoClient = contract::SdoTransfer<1024>;

// What an abort code means, in half a sentence (CiA 301, table 22); "unknown abort code" for those that it does not list.
[[nodiscard]] constexpr const char* sdo_abort_text(std::uint32_t code) {
  switch (code) {
    case 0x05030000:
      return "toggle bit not alternated";
    case 0x05040000:
      return "timed out";
    case 0x05040001:
      return "command not valid or unknown";
    case 0x05040005:
      return "too long for the memory that is there";
    case 0x06010000:
      return "access not supported";
    case 0x06010001:
      return "the object can only be written";
    case 0x06010002:
      return "the object can only be read";
    case 0x06020000:
      return "there is no such object";
    case 0x06040041:
      return "the object cannot be mapped into a PDO";
    case 0x06040042:
      return "more mapped than a PDO holds";
    case 0x06040043:
      return "parameters do not fit together";
    case 0x06060000:
      return "the hardware failed (flash)";
    case 0x06070010:
      return "wrong length";
    case 0x06070012:
      return "too long for the object";
    case 0x06070013:
      return "too short for the object";
    case 0x06090011:
      return "there is no such sub-index";
    case 0x06090030:
      return "value out of its range";
    case 0x06090031:
      return "value too high";
    case 0x06090032:
      return "value too low";
    case 0x08000000:
      return "general error";
    case 0x08000020:
      return "the data cannot be transferred or stored";
    case 0x08000021:
      return "not now: the device is under local control";
    case 0x08000022:
      return "not in the present state of the device";
    case 0x08000024:
      return "there is nothing there";
    default:
      return "unknown abort code";
  }
}

}  // namespace hoist::bus
