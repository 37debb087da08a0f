// The DBC and EDS files as other tools read them: parsed strictly, and the DBC compared with the C++ wire format.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {
namespace {

using namespace hoist::contract;

// ---- DBC ----

struct Signal {
  unsigned start = 0, bits = 0;
  bool is_signed = false;
  double scale = 1, offset = 0, min = 0, max = 0;
  std::set<std::string> receivers;
};
struct Message {
  std::string name, sender;
  unsigned bytes = 0;
  std::map<std::string, Signal> signals;
};
struct Dbc {
  std::set<std::string> nodes;
  std::map<unsigned, Message> messages;
  std::vector<std::string> errors;
};

// Accepts only the subset that we write: an unknown line is an error.
Dbc parse_dbc(const std::string& text) {
  static const std::regex message_line(R"re(BO_ (\d+) ([A-Za-z_]\w*): ([0-8]) ([A-Za-z_]\w*))re");
  static const std::regex signal_line(
      R"re( SG_ ([A-Za-z_]\w*) : (\d+)\|(\d+)@1([+-]) \(([^,()]+),([^,()]+)\) \[([^|\]]+)\|([^|\]]+)\] "([^"]*)" ([\w,]+))re");
  static const std::regex fixed_line(R"re(VERSION "[^"]*"|NS_ :|BS_:|)re");
  static const std::regex comment_line(R"re(CM_ (BO_ (\d+)|BU_ (\w+)) "[^"]*";)re");
  static const std::regex attribute_line(R"re(BA_DEF_ BO_ "(\w+)" INT \d+ \d+;|BA_DEF_DEF_ "(\w+)" \d+;|BA_ "(\w+)" BO_ (\d+) \d+;)re");
  static const std::regex value_line(R"re(VAL_ (\d+) (\w+)( \d+ "[^"]*")+ ;)re");
  Dbc dbc;
  Message* current = nullptr;
  std::set<std::string> names;
  std::istringstream stream(text);
  std::smatch match;
  for (std::string line; std::getline(stream, line);) {
    const auto wrong = [&](const std::string& why) { dbc.errors.push_back(why + ": " + line); };
    if (line.rfind("BU_:", 0) == 0) {
      std::istringstream list(line.substr(4));
      for (std::string node; list >> node;) {
        if (!dbc.nodes.insert(node).second) wrong("node twice");
      }
    } else if (std::regex_match(line, match, message_line)) {
      const auto id = static_cast<unsigned>(std::stoul(match[1]));
      if (id > 0x7FF) wrong("not an 11-bit id");
      if (dbc.messages.count(id) != 0 || !names.insert(match[2]).second) wrong("message twice");
      if (dbc.nodes.count(match[4]) == 0) wrong("unknown sender");
      current = &dbc.messages[id];
      *current = {match[2], match[4], static_cast<unsigned>(std::stoul(match[3])), {}};
    } else if (std::regex_match(line, match, signal_line)) {
      if (current == nullptr) {
        wrong("signal outside a message");
        continue;
      }
      Signal signal;
      signal.start = static_cast<unsigned>(std::stoul(match[2]));
      signal.bits = static_cast<unsigned>(std::stoul(match[3]));
      signal.is_signed = match[4] == "-";
      signal.scale = std::stod(match[5]);
      signal.offset = std::stod(match[6]);
      signal.min = std::stod(match[7]);
      signal.max = std::stod(match[8]);
      std::istringstream list(match[10]);
      for (std::string node; std::getline(list, node, ',');) {
        signal.receivers.insert(node);
        if (dbc.nodes.count(node) == 0) wrong("unknown receiver");
      }
      if (signal.bits == 0 || signal.start + signal.bits > 8 * current->bytes) wrong("signal outside its frame");
      if (signal.scale == 0 || signal.min >= signal.max) wrong("empty range");
      for (const auto& [name, other] : current->signals) {
        if (signal.start < other.start + other.bits && other.start < signal.start + signal.bits) wrong("signals overlap");
      }
      if (!current->signals.emplace(match[1], signal).second) wrong("signal twice");
    } else if (std::regex_match(line, match, comment_line)) {
      if (match[2].matched && dbc.messages.count(static_cast<unsigned>(std::stoul(match[2]))) == 0) wrong("comment on an unknown message");
      if (match[3].matched && dbc.nodes.count(match[3]) == 0) wrong("comment on an unknown node");
    } else if (std::regex_match(line, match, attribute_line)) {
      if (match[4].matched && dbc.messages.count(static_cast<unsigned>(std::stoul(match[4]))) == 0)
        wrong("attribute of an unknown message");
    } else if (std::regex_match(line, match, value_line)) {
      const auto at = dbc.messages.find(static_cast<unsigned>(std::stoul(match[1])));
      if (at == dbc.messages.end() || at->second.signals.count(match[2]) == 0) wrong("names for an unknown signal");
    } else if (line.empty()) {
      current = nullptr;
    } else if (!std::regex_match(line, fixed_line)) {
      wrong("unknown line");
    }
  }
  return dbc;
}

double decode(const Signal& signal, const CanFrame& frame) {
  std::uint64_t raw = 0;
  for (unsigned bit = 0; bit < signal.bits; ++bit) {
    const unsigned at = signal.start + bit;
    raw |= static_cast<std::uint64_t>((frame.data[at / 8] >> (at % 8)) & 1U) << bit;
  }
  auto value = static_cast<double>(raw);
  if (signal.is_signed && ((raw >> (signal.bits - 1)) & 1U) != 0) value -= static_cast<double>(std::uint64_t{1} << signal.bits);
  return value * signal.scale + signal.offset;
}

TEST(Dbc, IsSound) {
  const auto dbc = parse_dbc(dbc_file().text);
  EXPECT_TRUE(dbc.errors.empty()) << dbc.errors.front();
  EXPECT_EQ(dbc.nodes.size(), kNodes.size());
  // Every PDO of every node exists, with its length and direction.
  for (const auto& pdo : kPdos) {
    for (const auto& node : kNodes) {
      if (node.kind != pdo.kind) continue;
      const auto at = dbc.messages.find(static_cast<unsigned>(pdo.cob_base) + node.id);
      ASSERT_NE(at, dbc.messages.end()) << pdo.name << " of " << node.name;
      EXPECT_EQ(at->second.bytes, pdo_bytes(pdo.pdo));
      EXPECT_EQ(at->second.sender, pdo.direction == PdoDirection::tx ? std::string(node.name) : "core");
    }
  }
}

TEST(Dbc, TheParserRefusesWhatIsWrong) {
  const std::string nodes = "BU_: a b\n\n";
  const auto errors = [&](const std::string& text) { return parse_dbc(nodes + text).errors.size(); };
  EXPECT_EQ(errors("BO_ 1 m: 2 a\n SG_ s : 0|16@1+ (1,0) [0|9] \"\" b\n"), 0U);
  EXPECT_EQ(errors("BO_ 1 m: 2 c\n"), 1U) << "unknown sender";
  EXPECT_EQ(errors("BO_ 4000 m: 2 a\n"), 1U) << "id too large";
  EXPECT_EQ(errors("BO_ 1 m: 2 a\nBO_ 1 n: 2 a\n"), 1U) << "id twice";
  EXPECT_EQ(errors("BO_ 1 m: 2 a\n SG_ s : 1|16@1+ (1,0) [0|9] \"\" b\n"), 1U) << "outside the frame";
  EXPECT_EQ(errors("BO_ 1 m: 2 a\n SG_ s : 0|9@1+ (1,0) [0|9] \"\" b\n SG_ t : 8|8@1+ (1,0) [0|9] \"\" b\n"), 1U) << "overlap";
  EXPECT_EQ(errors("BO_ 1 m: 2 a\n SG_ s : 0|8@1+ (1,0) [0|9] \"\" c\n"), 1U) << "unknown receiver";
  EXPECT_EQ(errors("# a comment\n"), 1U) << "unknown line";
}

TEST(Dbc, DecodesWhatTheNodesEncode) {
  const auto dbc = parse_dbc(dbc_file().text);
  const auto expect = [&](Pdo pdo, Node node, PdoSlot slot, const std::string& name, std::int64_t raw) {
    CanFrame frame;
    frame.data.fill(0xA5);  // neighbours must not leak in
    write_slot(frame, slot, raw);
    const auto& message = dbc.messages.at(pdo_cob_id(pdo, node));
    EXPECT_DOUBLE_EQ(decode(message.signals.at(name), frame), static_cast<double>(raw) * slot.scale)
        << message.name << "." << name << " = " << raw;
  };
  for (const std::int64_t raw : {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{15000}, std::int64_t{-15000},
                                 std::int64_t{32767}, std::int64_t{-32768}}) {
    expect(Pdo::tilt_tx1, Node::tilt_left, pdo_slot(Pdo::tilt_tx1, 0x6010), "slope_long", raw);
    expect(Pdo::tilt_tx1, Node::tilt_base, pdo_slot(Pdo::tilt_tx1, 0x6020), "slope_lateral", raw);
    expect(Pdo::tilt_tx2, Node::tilt_base, pdo_slot(Pdo::tilt_tx2, 0x2110, 1), "rate_yaw", raw);
    expect(Pdo::drive_tx1, Node::drive_right, pdo_slot(Pdo::drive_tx1, 0x6078), "current", raw);
  }
  for (const std::int64_t raw : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{2147483647}, std::int64_t{-2147483647 - 1}}) {
    expect(Pdo::drive_tx1, Node::drive_left, pdo_slot(Pdo::drive_tx1, 0x6064), "position", raw);
    expect(Pdo::drive_rx1, Node::drive_left, pdo_slot(Pdo::drive_rx1, 0x60FF), "target_velocity", raw);
  }
  expect(Pdo::drive_tx1, Node::drive_left, pdo_slot(Pdo::drive_tx1, 0x6041), "status_word", 0xFFFF);
  expect(Pdo::drive_tx2, Node::drive_right, pdo_slot(Pdo::drive_tx2, 0x2211), "supply_10mv", 2400);
}

TEST(Dbc, IsReadByCanmatrix) {
  // Debian's own interpreter: another one on the path does not see Debian's packages.
  if (std::system("/usr/bin/python3 -c 'import canmatrix.formats' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-canmatrix is not installed";
  const std::string script =
      "import canmatrix.formats, sys; m = list(canmatrix.formats.loadp(sys.argv[1]).values())[0]; sys.exit(0 if len(m.frames) == "
      "int(sys.argv[2]) else 1)";
  const auto frames = parse_dbc(dbc_file().text).messages.size();
  const std::string command = "/usr/bin/python3 -c '" + script + "' '" + HOIST_SOURCE_DIR + "/" + dbc_file().path + "' " +
                              std::to_string(frames) + " >/dev/null 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

// ---- EDS ----

using Section = std::map<std::string, std::string>;
struct Eds {
  std::map<std::string, Section> sections;
  std::vector<std::string> errors;
};

Eds parse_eds(const std::string& text) {
  Eds eds;
  Section* current = nullptr;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == ';') continue;
    if (line.size() > 255) eds.errors.push_back("line longer than 255: " + line);
    if (line.front() == '[' && line.back() == ']') {
      const auto [at, is_new] = eds.sections.try_emplace(line.substr(1, line.size() - 2));
      if (!is_new) eds.errors.push_back("section twice: " + line);
      current = &at->second;
      continue;
    }
    const auto equals = line.find('=');
    if (current == nullptr || equals == std::string::npos || !current->emplace(line.substr(0, equals), line.substr(equals + 1)).second) {
      eds.errors.push_back("bad line: " + line);
    }
  }
  return eds;
}

// The rules of CiA 306 that a reader leans on.
std::vector<std::string> eds_faults(const std::string& text) {
  const auto eds = parse_eds(text);
  auto faults = eds.errors;
  if (text.find("$NODEID") != std::string::npos) faults.push_back("$NODEID is not worked out by every reader");
  std::set<std::string> listed;
  for (const std::string list : {"MandatoryObjects", "OptionalObjects", "ManufacturerObjects"}) {
    const auto at = eds.sections.find(list);
    if (at == eds.sections.end()) {
      faults.push_back(list + " is missing");
      continue;
    }
    const auto count = std::stoul(at->second.at("SupportedObjects"));
    if (at->second.size() != count + 1) faults.push_back(list + " has another length than it says");
    for (std::size_t i = 1; i <= count; ++i) {
      const auto entry = at->second.find(std::to_string(i));
      if (entry == at->second.end()) {
        faults.push_back(list + " has a gap");
        continue;
      }
      const auto index = entry->second.substr(2);
      if (!listed.insert(index).second) faults.push_back(index + " is listed twice");
      if (eds.sections.count(index) == 0) faults.push_back(index + " is listed and not described");
    }
  }
  for (const std::string index : {"1000", "1001", "1018"}) {
    if (listed.count(index) == 0) faults.push_back(index + " is mandatory");
  }
  static const std::regex object_section(R"(([0-9A-F]{4})(sub([0-9A-F]+))?)");
  std::map<std::string, unsigned> members;
  std::smatch match;
  for (const auto& [name, section] : eds.sections) {
    if (!std::regex_match(name, match, object_section)) continue;
    if (listed.count(match[1]) == 0) faults.push_back(name + " is described and not listed");
    if (match[2].matched) ++members[match[1]];
    if (section.at("ObjectType") == "0x9") continue;
    for (const char* key : {"ParameterName", "DataType", "AccessType", "PDOMapping"}) {
      if (section.count(key) == 0) faults.push_back(name + " lacks " + key);
    }
    static const std::set<std::string> types = {"0x0002", "0x0003", "0x0004", "0x0005", "0x0006", "0x0007", "0x0008", "0x0009"};
    if (types.count(section.at("DataType")) == 0) faults.push_back(name + " has an unknown type");
  }
  for (const auto& [index, count] : members) {
    const auto said = std::stoul(eds.sections.at(index).at("SubNumber"), nullptr, 16);
    if (said != count) faults.push_back(index + " has another number of sub-indices than it says");
    if (eds.sections.count(index + "sub0") == 0) faults.push_back(index + " has no sub-index 0");
  }
  return faults;
}

TEST(Eds, EachNodeHasASoundOne) {
  const auto files = eds_files();
  ASSERT_EQ(files.size(), kRemoteNodeCount);
  for (const auto& file : files) {
    const auto faults = eds_faults(file.text);
    EXPECT_TRUE(faults.empty()) << file.path << ": " << faults.front();
  }
}

TEST(Eds, NodeNumbersAreWrittenOut) {
  for (const auto& file : eds_files()) {
    const auto eds = parse_eds(file.text);
    for (const auto& node : kNodes) {
      if (file.path != "firmware/nodes/eds/" + std::string(node.name) + ".gen.eds") continue;
      EXPECT_EQ(std::stoul(eds.sections.at("1014").at("DefaultValue"), nullptr, 0), canopen::kEmcyBase + node.id);
      EXPECT_EQ(std::stoul(eds.sections.at("1200sub1").at("DefaultValue"), nullptr, 0), canopen::kSdoRequestBase + node.id);
      EXPECT_EQ(std::stoul(eds.sections.at("1800sub1").at("DefaultValue"), nullptr, 0), 0x40000180U + node.id);
      // A tool finds the file for a device by these numbers; the device says the same (test_eds_served).
      const Section& device = eds.sections.at("DeviceInfo");
      for (const auto& [key, section] :
           {std::pair{"VendorNumber", "1018sub1"}, {"ProductNumber", "1018sub2"}, {"RevisionNumber", "1018sub3"}})
        EXPECT_EQ(std::stoul(device.at(key), nullptr, 0), std::stoul(eds.sections.at(section).at("DefaultValue"), nullptr, 0)) << key;
      EXPECT_EQ(std::stoul(device.at("ProductNumber"), nullptr, 0), static_cast<unsigned>(node.kind) + 1);
    }
  }
}

TEST(Eds, TheChecksFindWhatIsWrong) {
  const auto good = eds_files().front().text;
  ASSERT_TRUE(eds_faults(good).empty());
  const auto with = [&](const std::string& from, const std::string& to) {
    auto text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return eds_faults(text.replace(at, from.size(), to)).size();
  };
  EXPECT_GT(with("DataType=0x0007", "DataType=0x0099"), 0U);
  EXPECT_GT(with("1=0x1000", "1=0x1FFF"), 0U);
  EXPECT_GT(with("SubNumber=0x5", "SubNumber=0x6"), 0U);
  EXPECT_GT(with("[1001]", "[1000]"), 0U);
  EXPECT_GT(with("DefaultValue=0x081", "DefaultValue=$NODEID+0x80"), 0U);
}

}  // namespace
}  // namespace hoist::gen
