// The control core and nodes that are in their loader: such a hoist never moves, and a moving hoist never enters a loader.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/closed_loop.hpp"
#include "tests/unit/boot/boot_support.hpp"

namespace hoist::firmware {
namespace {

using contract::Mode;
using contract::Node;
using tests::ClosedLoop;

class LoaderUnderCore : public testing::TestWithParam<Node> {};

TEST_P(LoaderUnderCore, AHoistWithANodeWithoutProgramNeverMoves) {
  const Node node = GetParam();
  ClosedLoop loop({});
  // Unplugged drives keep their supply; a watchdog reset restarts any node.
  loop.world().program_flash(node)->burn({});
  loop.world().freeze(node, true);
  loop.world().freeze(node, false);
  ASSERT_TRUE(loop.world().in_loader(node));
  EXPECT_FALSE(loop.start(Mode::user));
  EXPECT_FALSE(
      loop.run_until([&] { return loop.world().drives_enabled() || loop.mode() == Mode::user || loop.mode() == Mode::standby; }, 20.0));
  EXPECT_TRUE(loop.world().in_loader(node));
  // A program comes, and with it the hoist.
  const auto kind = static_cast<ImageKind>(contract::kNodes[static_cast<std::size_t>(node)].kind);
  loop.world().program_flash(node)->burn(make_image(1000, contract::image_version(1, 4, 0), 1, kind));
  loop.world().freeze(node, true);
  loop.world().freeze(node, false);
  EXPECT_FALSE(loop.world().in_loader(node));
}

// In operation no node ends its program, for any request.
TEST_P(LoaderUnderCore, AHoistAtWorkKeepsItsPrograms) {
  const Node node = GetParam();
  ClosedLoop loop({});
  ASSERT_TRUE(loop.start(Mode::user));
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(loop.world().host_send(canopen::sdo(canopen::kSdoRequestBase + contract::node_id(node), canopen::sdo_download_command(1),
                                                    contract::kProgramControl, 1, static_cast<std::uint32_t>(i % 4))));
    loop.run(0.1);
    ASSERT_FALSE(loop.world().in_loader(node));
    ASSERT_EQ(loop.mode(), Mode::user) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Nodes, LoaderUnderCore,
                         testing::Values(Node::drive_left, Node::drive_right, Node::tilt_left, Node::tilt_base, Node::io),
                         [](const auto& test) { return std::string(contract::kNodes[static_cast<std::size_t>(test.param)].name); });

}  // namespace
}  // namespace hoist::firmware
