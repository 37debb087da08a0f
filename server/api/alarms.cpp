#include "server/api/alarms.hpp"

#include <string>

#include "control/contract/emergencies.hpp"
#include "control/contract/faults.hpp"

namespace hoist::server {

using contract::Fault;
using nlohmann::json;

namespace {

std::uint16_t code_of(const contract::TickRecord& record, Fault fault) {
  switch (fault) {
    case Fault::drive_left_fault:
      return record.drive_left_fault_code;
    case Fault::drive_right_fault:
      return record.drive_right_fault_code;
    case Fault::tilt_implausible:
      return record.tilt_implausible_code;
    case Fault::overspeed:
      return record.overspeed_code;
    default:
      return 0;
  }
}

json words(std::string en, std::string de) { return {{"en", std::move(en)}, {"de", std::move(de)}}; }

json alarm_json(const contract::TickRecord& record, Fault fault, const json& consequence_of) {
  const contract::FaultInfo& info = contract::fault_info(fault);
  const std::uint16_t code = code_of(record, fault);
  std::string en{info.text_en}, de{info.text_de}, action_en{info.action_en}, action_de{info.action_de};
  if (const contract::DetailInfo* detail = contract::find_detail(fault, code)) {
    en = detail->text_en;
    de = detail->text_de;
    action_en = detail->action_en;
    action_de = detail->action_de;
  } else if (code != 0 && (fault == Fault::drive_left_fault || fault == Fault::drive_right_fault)) {
    const contract::EmergencyInfo& emergency = contract::emergency_info(code);
    en += ": " + std::string(emergency.text_en);
    de += ": " + std::string(emergency.text_de);
  }
  return {{"name", info.name},
          {"code", code},
          {"text", words(std::move(en), std::move(de))},
          {"action", words(std::move(action_en), std::move(action_de))},
          {"consequence_of", consequence_of}};
}

}  // namespace

json alarms_json(const contract::TickRecord& record) {
  json alarms = json::array();
  std::uint32_t left = record.fault_bits;
  // A bit that no row has would never be taken.
  std::uint32_t known = 0;
  for (const contract::FaultInfo& info : contract::kFaults) known |= 1U << info.bit;
  left &= known;
  while (left != 0) {
    const Fault cause = contract::headline(left, record.stop_cause);
    alarms.push_back(alarm_json(record, cause, nullptr));
    left &= ~contract::fault_bit(cause);
    for (const contract::Explanation& row : contract::kExplanations) {
      if (row.cause != cause || (left & contract::fault_bit(row.effect)) == 0) continue;
      alarms.push_back(alarm_json(record, row.effect, contract::fault_info(cause).name));
      left &= ~contract::fault_bit(row.effect);
    }
  }
  return alarms;
}

}  // namespace hoist::server
