// A row more in faults.def is all that a new fault takes, also beyond the 32nd. Compiled with tests/contract/more_faults.def as the table.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "control/contract/signals.hpp"
#include "server/api/alarms.hpp"

namespace hoist::contract {
namespace {

constexpr FaultBits kBoth = fault_bit(Fault::seat_open) | fault_bit(Fault::lamp_broken);

TEST(FaultRoom, ThePlacesBeyond32AreFaultsLikeTheOthers) {
  EXPECT_EQ(kBoth, 0x0018'0000'0000'0000U);
  ASSERT_NE(find_fault("seat_open"), nullptr);
  EXPECT_EQ(find_fault("seat_open")->hazard(), "2.3");
  EXPECT_EQ(consequences(kBoth), fault_bit(Fault::lamp_broken));
  EXPECT_EQ(first_cause(kBoth | fault_bit(Fault::battery_low)), Fault::seat_open);
  const FaultBits two = fault_bit(Fault::seat_open) | fault_bit(Fault::tilt_frozen);
  EXPECT_EQ(headline(two), Fault::tilt_frozen);
  EXPECT_EQ(headline(two, static_cast<std::uint8_t>(Fault::seat_open) + 1), Fault::seat_open);
}

TEST(FaultRoom, TheRecordHoldsEachOfThemAlsoAsANumber) {
  TickRecord record;
  for (const FaultInfo& info : kFaults) {
    record.fault_bits = fault_bit(info);
    EXPECT_EQ(static_cast<FaultBits>(signal_value(record, *find_signal("fault_bits"))), fault_bit(info)) << info.name;
  }
}

TEST(FaultRoom, RestNamesThem) {
  EXPECT_EQ(server::fault_names(kBoth | fault_bit(Fault::tilt_left_lost)),
            (std::vector<std::string>{"tilt_left_lost", "seat_open", "lamp_broken"}));
  TickRecord record;
  record.fault_bits = kBoth;
  record.stop_cause = static_cast<std::uint8_t>(Fault::seat_open) + 1;
  server::JsonWriter out(1024);
  server::write_alarms(out, record);
  const auto alarms = nlohmann::json::parse(out.take());
  ASSERT_EQ(alarms.size(), 2U);
  EXPECT_EQ(alarms[0]["name"], "seat_open");
  EXPECT_EQ(alarms[0]["text"]["de"], "Der Sitz ist offen");
  EXPECT_EQ(alarms[0]["consequence_of"], nullptr);
  EXPECT_EQ(alarms[1]["name"], "lamp_broken");
  EXPECT_EQ(alarms[1]["consequence_of"], "seat_open");
}

}  // namespace
}  // namespace hoist::contract
