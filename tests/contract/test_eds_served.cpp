// The EDS of each node against the node itself, over SDO: everything listed is served with the length, access and default that the file
// says, and everything served is listed.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "control/bus/sdo_client.hpp"
#include "deploy/tools/gen/generate.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::gen {
namespace {

using bus::SdoClient;
using contract::CanFrame;
using contract::Node;
using contract::NodeKind;

struct Entry {
  std::map<std::string, std::string> keys;
  [[nodiscard]] std::string get(const std::string& key) const {
    const auto at = keys.find(key);
    return at == keys.end() ? std::string() : at->second;
  }
};
using Address = std::pair<unsigned, unsigned>;

// The sections [1A00] and [1A00sub3] that describe a value rather than a record.
std::map<Address, Entry> read_eds(const std::string& text) {
  std::map<Address, Entry> entries;
  std::istringstream lines(text);
  Entry* current = nullptr;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == ';') continue;
    if (line[0] == '[') {
      unsigned index = 0, sub = 0;
      const bool is_sub = std::sscanf(line.c_str(), "[%4Xsub%X]", &index, &sub) == 2;
      const bool is_object = is_sub || (line.size() == 6 && std::sscanf(line.c_str(), "[%4X]", &index) == 1);
      current = is_object ? &entries[{index, is_sub ? sub : 0}] : nullptr;
    } else if (current != nullptr) {
      const auto equals = line.find('=');
      current->keys[line.substr(0, equals)] = line.substr(equals + 1);
    }
  }
  for (auto at = entries.begin(); at != entries.end();) at = at->second.get("DataType").empty() ? entries.erase(at) : std::next(at);
  return entries;
}

// One node and an SDO client in virtual time.
class Asked {
 public:
  virtual ~Asked() = default;
  [[nodiscard]] const SdoClient& ask(const std::function<bool(SdoClient&)>& begin) {
    EXPECT_TRUE(begin(client_));
    for (int i = 0; i < 1000 && client_.outcome() == SdoClient::Outcome::busy; ++i) {
      now_ns_ += 5'000'000;  // beyond the client's pace; the node needs no time
      board_.sent.clear();
      if (const auto frame = client_.step(now_ns_)) on_frame(*frame);
      for (const CanFrame& frame : board_.sent) client_.on_frame(frame);
    }
    return client_;
  }
  virtual void on_frame(const CanFrame& frame) = 0;
  virtual std::size_t rows() const = 0;

 protected:
  firmware::TestBoard board_;
  SdoClient client_;
  std::uint64_t now_ns_ = 0;
};
template <template <class> class NodeOf, NodeKind kKind>
class AskedNode final : public Asked {
 public:
  explicit AskedNode(Node node) : node_(board_, node) { firmware::tick(node_, 1); }
  void on_frame(const CanFrame& frame) override { node_.on_frame(frame); }
  std::size_t rows() const override { return firmware::kObjectRows<kKind>.size(); }

 private:
  NodeOf<firmware::TestBoard> node_;
};
std::unique_ptr<Asked> make_node(Node node) {
  switch (contract::kNodes[static_cast<std::size_t>(node)].kind) {
    case NodeKind::drive:
      return std::make_unique<AskedNode<firmware::DriveNode, NodeKind::drive>>(node);
    case NodeKind::tilt:
      return std::make_unique<AskedNode<firmware::TiltNode, NodeKind::tilt>>(node);
    default:
      return std::make_unique<AskedNode<firmware::IoNode, NodeKind::io>>(node);
  }
}

std::size_t bytes_of(unsigned data_type) {
  constexpr std::array<std::size_t, 10> kBytes = {0, 0, 1, 2, 4, 1, 2, 4, 4, 0};
  return data_type < kBytes.size() ? kBytes[data_type] : 0;
}
// The default of the file as the bytes that travel.
std::uint32_t raw_default(const std::string& text, unsigned data_type) {
  if (data_type == 8) {
    const float value = std::stof(text);
    std::uint32_t raw;
    std::memcpy(&raw, &value, 4);
    return raw;
  }
  const long long value = std::stoll(text, nullptr, 0);
  const std::size_t bytes = bytes_of(data_type);
  return static_cast<std::uint32_t>(bytes == 4 ? value : value & ((1LL << (8 * bytes)) - 1));
}

class EdsOfNode : public ::testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    const contract::NodeInfo& info = contract::kNodes[GetParam()];
    id_ = info.id;
    node_ = make_node(static_cast<Node>(GetParam()));
    for (const auto& file : eds_files())
      if (file.path == "firmware/nodes/eds/" + std::string(info.name) + ".gen.eds") eds_ = read_eds(file.text);
    ASSERT_GT(eds_.size(), 40U);
  }
  std::uint8_t id_ = 0;
  std::unique_ptr<Asked> node_;
  std::map<Address, Entry> eds_;
};

TEST_P(EdsOfNode, EverythingListedIsServedAsItIsListed) {
  for (const auto& [address, entry] : eds_) {
    const auto index = static_cast<std::uint16_t>(address.first);
    const auto sub = static_cast<std::uint8_t>(address.second);
    const std::string where = entry.get("ParameterName") + " " + std::to_string(index) + ":" + std::to_string(sub);
    const auto type = static_cast<unsigned>(std::stoul(entry.get("DataType"), nullptr, 0));
    const SdoClient& got = node_->ask([&](SdoClient& client) { return client.upload(id_, index, sub); });
    if (index == 0x1003 && sub != 0) {  // there is no error
      EXPECT_EQ(got.abort_code(), 0x08000024U) << where;
    } else {
      ASSERT_EQ(got.outcome(), SdoClient::Outcome::done) << where;
      if (type == 9) {
        EXPECT_GT(got.uploaded().size(), 4U) << where;
      } else {
        EXPECT_EQ(got.uploaded().size(), bytes_of(type)) << where;
      }
    }
    const std::string access = entry.get("AccessType");
    const std::string standard = entry.get("DefaultValue");
    const bool identity = index == 0x1000 || (index == 0x1018 && sub < 4);
    EXPECT_TRUE(!identity || !standard.empty()) << where;
    // What a node measures has moved on from its default; what it is has not. Bit 31 of the product is the simulator's.
    if (identity)
      EXPECT_EQ(got.value() & ~(sub == 2 ? contract::canopen::kSimulatedProduct : 0U), raw_default(standard, type)) << where;
    else if (!standard.empty() && access != "ro") {
      EXPECT_EQ(got.value(), raw_default(standard, type)) << where;
    }
    // Read-only objects refuse writes; writable ones accept their own value. Commands are left out, and process inputs ("rww"), which some
    // nodes accept only from their RPDO.
    if (access == "rww") continue;
    if (access != "rw") {
      const std::array<std::uint8_t, 1> one = {1};
      EXPECT_EQ(node_->ask([&](SdoClient& client) { return client.download(id_, index, sub, one); }).abort_code(), 0x06010002U) << where;
    } else if (index != 0x1003 && index != 0x1010 && index != 0x1011 && !(index >= 0x1F50 && index < 0x1F60)) {
      const std::vector<std::uint8_t> same(got.uploaded().begin(), got.uploaded().end());
      EXPECT_EQ(node_->ask([&](SdoClient& client) { return client.download(id_, index, sub, same); }).outcome(), SdoClient::Outcome::done)
          << where;
    }
  }
}

TEST_P(EdsOfNode, EverythingServedIsListed) {
  std::size_t served = 0;
  for (unsigned index = 0x1000; index < 0x7000; ++index) {
    for (unsigned sub = 0; sub <= 10; ++sub) {
      const SdoClient& got = node_->ask(
          [&](SdoClient& client) { return client.upload(id_, static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)); });
      const bool there = got.outcome() == SdoClient::Outcome::done || got.abort_code() == 0x08000024U;
      if (!there && got.abort_code() == 0x06020000U && sub == 0) break;  // no such object: no sub-index either
      EXPECT_EQ(there, eds_.count({index, sub}) == 1) << std::hex << index << ":" << sub;
      served += there ? 1U : 0U;
    }
  }
  EXPECT_EQ(served, eds_.size());
  EXPECT_GE(served, node_->rows());
}

INSTANTIATE_TEST_SUITE_P(All, EdsOfNode, ::testing::Range<std::size_t>(0, contract::kRemoteNodeCount),
                         [](const auto& which) { return std::string(contract::kNodes[which.param].name); });

}  // namespace
}  // namespace hoist::gen
