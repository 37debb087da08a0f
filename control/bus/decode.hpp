// Decodes a frame into words and units: names as in the generated DBC, values scaled by the rows of can_dictionary.def.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/can_frame.hpp"

namespace hoist::bus {

struct DecodedField {
  std::string name;
  double value = 0;
  std::string unit;     // empty where there is none
  std::string meaning;  // the value's name if it has one: "operational"
  bool hex = false;     // people read it in hexadecimal: identifiers, codes
};
struct DecodedFrame {
  std::string name;     // "drive_left_tx1"; empty when no node of the dictionary sends such a frame
  std::string problem;  // why the content cannot be taken: "6 bytes instead of 8"
  std::vector<DecodedField> fields;
};

[[nodiscard]] DecodedFrame decode_frame(const contract::CanFrame& frame);

}  // namespace hoist::bus
