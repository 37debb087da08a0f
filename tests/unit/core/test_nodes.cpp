// Which node fills which sensor, what a frame is, and that the core's faults have room beyond 32.
#include <gtest/gtest.h>

#include "control/contract/classify.hpp"
#include "control/core/receive.hpp"
#include "control/core/record.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::CanFrame;
using contract::classify;
using contract::CobKind;
using contract::FaultBits;
using contract::FrameClass;
using contract::Node;
using contract::Pdo;
namespace canopen = contract::canopen;

CanFrame angles(std::uint32_t node_id, std::int64_t raw, std::uint8_t counter) {
  CanFrame frame{0x180 + node_id, contract::pdo_bytes(Pdo::tilt_tx1), 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x6010), raw);
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), tilt_status::kValid);
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), counter);
  return frame;
}

TEST(Nodes, EachFillsItsOwnSensorAndNoOther) {
  Estimate sensed;
  BusMaster master;
  const Derived derived = derive(contract::Params{});
  for (const NodeRow& row : kNodeRows) {
    sensed = {};
    const contract::NodeKind kind = contract::kNodes[static_cast<std::size_t>(row.node)].kind;
    CanFrame frame = angles(contract::node_id(row.node), 500, 1);
    if (kind != contract::NodeKind::tilt) frame.dlc = contract::pdo_bytes(kind == contract::NodeKind::drive ? Pdo::drive_tx1 : Pdo::io_tx1);
    EXPECT_TRUE(receive(frame, classify(frame), sensed, master, derived, kTick_s));
    for (const NodeRow& other : kNodeRows) EXPECT_EQ(sensed.heard(other.node).now(), other.node == row.node);
    sensed.restart(row.node);
    EXPECT_FALSE(sensed.heard(row.node).now());
  }
  EXPECT_TRUE(sensed.heard(Node::core).lost()) << "no node may use the core's identifiers";
}

// The identity is four bytes: neither the answer to a write, nor two bytes, nor segments, nor a segment's answer.
TEST(Nodes, AnAnswerThatNoServerMayGiveIsNotTakenAndAskedAgain) {
  namespace canopen = contract::canopen;
  const std::uint8_t id = contract::node_id(Node::drive_left);
  const auto answer = [&](std::uint8_t command) { return canopen::sdo(canopen::kSdoReplyBase + id, command, 0x1018, 2, 0x00010203); };
  for (const std::uint8_t command : {0x60, 0x4B, 0x41, 0x00}) {
    SCOPED_TRACE(static_cast<int>(command));
    BusMaster master;
    EXPECT_FALSE(master.take_heartbeat(Node::drive_left, 127));
    FixedVector<CanFrame, 16> first, second, third;
    master.step(1, {}, {}, false, first);
    ASSERT_EQ(first.size(), 1U);
    EXPECT_EQ(first[0].data[0], canopen::kSdoUploadRequest);
    EXPECT_FALSE(master.take_sdo_reply(Node::drive_left, answer(command)));
    master.step(2, {}, {}, false, second);
    ASSERT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0].data, first[0].data);
    EXPECT_TRUE(master.take_sdo_reply(Node::drive_left, answer(canopen::sdo_upload_reply_command(4))));
    master.step(3, {}, {}, false, third);
    ASSERT_EQ(third.size(), 1U);
    EXPECT_EQ(third[0].data[3], 3) << "the revision is asked for next";
  }
}

TEST(Nodes, AnUnknownOneIsRefusedAndCountedAndFillsNothing) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.reach(Mode::standby));
  const double before_rad = hoist.state.sensed.base.sent_alpha_rad();
  const std::uint32_t refused = hoist.state.bus_refused;
  // Free ids around those of the tilt sensors, and the core's own.
  for (const std::uint32_t id : {0x10U, 0x14U, 0x20U, 0x7FU}) hoist.extra.push_back(angles(id, 500, 200));
  hoist.step();
  EXPECT_EQ(hoist.state.bus_refused, refused + 4);
  EXPECT_NEAR(hoist.state.sensed.base.sent_alpha_rad(), before_rad, 1e-3) << "its own noise, not the 500 of a stranger";
}

constexpr auto changed(std::size_t row, void (*change)(NodeRow&)) {
  auto rows = kNodeRows;
  change(rows[row]);
  return rows;
}
constexpr auto kBase = static_cast<std::size_t>(Node::tilt_base);
constexpr auto kLeftDrive = static_cast<std::size_t>(Node::drive_left);

// What does not compile as kNodeRows.
static_assert(rows_are_sound(kNodeRows));
static_assert(!rows_are_sound(std::array<NodeRow, 1>{kNodeRows[0]}), "nodes without a row");
static_assert(!rows_are_sound(changed(kBase, [](NodeRow& r) { r.tilt = &Estimate::left_strut; })), "two nodes fill one sensor");
static_assert(!rows_are_sound(changed(kBase, [](NodeRow& r) { r.zero = &Derived::left_zero; })), "two sensors have one zero");
static_assert(!rows_are_sound(changed(kBase, [](NodeRow& r) { r.zero = nullptr; })), "a sensor without its zero");
static_assert(!rows_are_sound(changed(kBase, [](NodeRow& r) { r.lost = Fault::tilt_left_lost; })), "two nodes have one fault");
static_assert(!rows_are_sound(changed(kBase, [](NodeRow& r) { r.node = Node::tilt_left; })), "another order");
static_assert(!rows_are_sound(changed(kLeftDrive, [](NodeRow& r) { r.drive = nullptr; })), "not the sensor of its kind");
static_assert(!rows_are_sound(changed(kLeftDrive, [](NodeRow& r) { r.io = &Estimate::io; })), "two sensors");

TEST(Classify, EveryIdHasOneKindAndTheLengthOfTheDictionary) {
  std::size_t planned = 0;
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    const FrameClass what = classify({id, 0, 0, {}});
    const auto node = contract::find_node(static_cast<std::uint8_t>(id & 0x7F));
    EXPECT_EQ(what.node, node ? static_cast<std::size_t>(*node) : contract::kNodes.size()) << id;
    if (what.pdo < contract::kPdos.size()) {
      const contract::PdoInfo& pdo = contract::kPdos[what.pdo];
      EXPECT_EQ(contract::pdo_cob_id(pdo.pdo, *node), id);
      EXPECT_EQ(contract::kNodes[what.node].kind, pdo.kind) << id;
      EXPECT_EQ(what.bytes, contract::pdo_bytes(pdo.pdo));
    }
    planned += what.bytes != contract::kNotPlanned ? 1U : 0U;
    for (int dlc = 0; dlc <= 255; ++dlc) {
      const FrameClass sized = classify({id, static_cast<std::uint8_t>(dlc), 0, {}});
      EXPECT_EQ(sized.fits, what.bytes != contract::kNotPlanned && dlc == what.bytes);
    }
    for (const std::uint8_t flag : {CanFrame::kExtended, CanFrame::kRemote, CanFrame::kError})
      EXPECT_EQ(classify({id, what.bytes, flag, {}}).kind, CobKind::unknown);
    EXPECT_EQ(classify({id + 0x800, what.bytes, 0, {}}).kind, CobKind::unknown);
  }
  // NMT, SYNC; of each node emergency, both of SDO, heartbeat; the core's heartbeat; every PDO of every node.
  std::size_t pdos = 0;
  for (const contract::PdoInfo& pdo : contract::kPdos)
    for (const contract::NodeInfo& node : contract::kNodes) pdos += node.kind == pdo.kind ? 1U : 0U;
  EXPECT_EQ(planned, 2 + 4 * contract::kRemoteNodeCount + 1 + pdos);
}

TEST(Classify, TheFixedIdentifiers) {
  EXPECT_EQ(classify(canopen::sync()).kind, CobKind::sync);
  EXPECT_EQ(classify(canopen::nmt(canopen::NmtCommand::start, 1)).kind, CobKind::nmt);
  const FrameClass beat = classify(canopen::heartbeat(contract::node_id(Node::core), canopen::NmtState::operational));
  EXPECT_EQ(beat.kind, CobKind::heartbeat);
  EXPECT_TRUE(beat.is_of(Node::core) && !beat.is_remote() && beat.fits);
  const FrameClass request = classify(canopen::sdo(0x611, canopen::kSdoUploadRequest, 0x1018, 2, 0));
  EXPECT_EQ(request.kind, CobKind::sdo_request);
  EXPECT_TRUE(request.is_of(Node::tilt_left) && request.is_remote() && request.fits);
  EXPECT_EQ(classify(canopen::sdo(0x591, canopen::kSdoDownloadReply, 0x1018, 2, 0)).kind, CobKind::sdo_reply);
  EXPECT_EQ(classify({0x093, 8, 0, {}}).kind, CobKind::emergency);
  EXPECT_EQ(classify({0x202, 6, 0, {}}).kind, CobKind::rpdo1);
}

// No row of the table has this place: what counts is that nothing on the way is narrower.
constexpr FaultBits kHigh = FaultBits{1} << 40U;

TEST(FaultBitsOfTheCore, ThePlacesBeyond32ReachRecordAndEvents) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.reach(Mode::standby));
  EventSink::List& events = hoist.out.events;
  events.clear();
  hoist.state.events.begin(events);
  judge_faults(hoist.state, kHigh);
  contract::TickRecord record;
  fill_record(hoist.state, {}, {}, record);
  EXPECT_EQ(record.fault_bits, kHigh);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, EventKind::fault_raised);
  EXPECT_EQ(events[0].code, 40U);
  events.clear();
  judge_faults(hoist.state, 0);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, EventKind::fault_cleared);
  EXPECT_EQ(events[0].code, 40U);
}

TEST(FaultBitsOfTheCore, AnAcknowledgementNamesThemToo) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  EXPECT_EQ(hoist.ask(contract::CommandKind::stop, 99), 0U);
  hoist.step(150);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  // Cut to 32 bits this would be "not told", which releases every latched fault.
  const std::uint32_t id = hoist.send(contract::CommandKind::acknowledge);
  hoist.commands.back().bits = kHigh;
  hoist.step();
  EXPECT_EQ(hoist.answer(id), contract::refusal_bit(contract::Refusal::cause_not_seen));
}

}  // namespace
}  // namespace hoist::core::test
