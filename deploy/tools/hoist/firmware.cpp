// hoist firmware: the programs of the nodes as files and on the bus.
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/firmware/bus_work.hpp"
#include "deploy/tools/hoist/firmware/image_file.hpp"
#include "deploy/tools/hoist/out_file.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kFirmwareHelp =
    "usage: hoist firmware pack IN.bin OUT.hoistfw [--simulated]\n"
    "       hoist firmware show FILE.hoistfw [--json]\n"
    "       hoist firmware list --bus ADDRESS [--json]\n"
    "       hoist firmware update --bus ADDRESS --node NODE FILE.hoistfw [--force]\n\n"
    "pack    adds length and CRC to a linked program; kind of node, chip and version are compiled into it\n"
    "        (--simulated: for the simulated node of its kind, which no chip takes)\n"
    "show    what a packed program is, or why it is none\n"
    "list    the programs of all nodes\n"
    "update  brings a program into a node: refused while a control computer or a drive is at work, wrong or older programs are refused\n"
    "        before anything is erased (--force: also an older one). When it breaks off, the node waits in its loader: run the same "
    "again\n\n"
    "NODE     drive_left, drive_right, io, tilt_left, tilt_right, tilt_base\n"
    "ADDRESS  slcan:/dev/ttyUSB0 or socketcan:can0\n";

int bad_usage(const std::string& sentence) {
  std::fprintf(stderr, "hoist firmware: %s (see hoist firmware --help)\n", sentence.c_str());
  return kBadUsage;
}
int refuse(const std::string& sentence) {
  std::fprintf(stderr, "hoist firmware: %s\n", sentence.c_str());
  return kRefused;
}

// The arguments of the verb: positional ones in order, and the options that each verb allows.
struct Words {
  std::vector<std::string> places;
  std::optional<std::string> bus, node;
  bool json = false, force = false, simulated = false;
};
// Empty when they were understood.
std::string read_words(std::span<const std::string_view> arguments, std::string_view allowed, Words& words) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (!argument.starts_with("--")) {
      words.places.emplace_back(argument);
      continue;
    }
    const std::string entry = std::string(argument) + ' ';
    if (allowed.find(entry) == std::string_view::npos) return "there is no option " + std::string(argument) + " here";
    if (argument == "--json") {
      words.json = true;
      continue;
    }
    if (argument == "--force") {
      words.force = true;
      continue;
    }
    if (argument == "--simulated") {
      words.simulated = true;
      continue;
    }
    if (i + 1 == arguments.size()) return std::string(argument) + " needs a value";
    (argument == "--bus" ? words.bus : words.node) = std::string(arguments[++i]);
  }
  return {};
}

int pack(const Words& words) {
  if (words.places.size() != 2) return bad_usage("pack needs the linked program and the file to write");
  std::vector<std::uint8_t> image;
  if (const Refusal why = read_file(words.places[0], image); !why.empty()) return refuse(why);
  if (const Refusal why = pack_image(image, words.simulated); !why.empty()) return refuse(words.places[0] + ": " + why);
  const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
  if (const db::Status written = write_file(words.places[1], bytes); !written) return refuse(written.error().message);
  const contract::ImageHeader header = contract::read_image_header(image);
  const contract::ImageChipInfo& chip = *contract::find_image_chip(header.chip);
  std::printf("%s: %s for %s, version %s, %zu of %u bytes\n", words.places[1].c_str(),
              std::string(contract::find_image_kind(header.kind)->name).c_str(), std::string(chip.name).c_str(),
              version_text(header.version).c_str(), image.size(), static_cast<unsigned>(chip.application_max));
  return kDone;
}

// Reads a packed program from a file; on error prints the reason and returns false.
bool read_image(const std::string& path, std::vector<std::uint8_t>& image) {
  if (const Refusal why = read_file(path, image); !why.empty()) return refuse(why), false;
  const contract::ImageError error = contract::check_image_file(image);
  if (error != contract::ImageError::none) return refuse(path + ": " + std::string(contract::image_error_text(error))), false;
  return true;
}

int show(const Words& words) {
  if (words.places.size() != 1) return bad_usage("show needs one file");
  std::vector<std::uint8_t> image;
  if (!read_image(words.places[0], image)) return kRefused;
  const contract::ImageHeader header = contract::read_image_header(image);
  const std::string kind(contract::find_image_kind(header.kind)->name), chip(contract::find_image_chip(header.chip)->name);
  if (words.json)
    std::printf(R"({"kind":"%s","chip":"%s","version":"%s","length":%u,"crc":"%08x"})"
                "\n",
                kind.c_str(), chip.c_str(), version_text(header.version).c_str(), static_cast<unsigned>(header.length),
                static_cast<unsigned>(header.crc));
  else
    std::printf("kind     %s\nchip     %s\nversion  %s\nlength   %u bytes\ncrc      %08x\n", kind.c_str(), chip.c_str(),
                version_text(header.version).c_str(), static_cast<unsigned>(header.length), static_cast<unsigned>(header.crc));
  return kDone;
}

int list(const Words& words) {
  if (!words.bus || !words.places.empty()) return bad_usage("list needs --bus and nothing else");
  return list_nodes(*words.bus, words.json);
}

int update(const Words& words) {
  if (words.places.size() != 1 || !words.bus || !words.node) return bad_usage("update needs --bus, --node and a file");
  const auto row = std::find_if(contract::kNodes.begin(), contract::kNodes.end(),
                                [&](const auto& info) { return info.name == *words.node && info.kind != contract::NodeKind::host; });
  if (row == contract::kNodes.end()) return bad_usage("--node: drive_left, drive_right, io, tilt_left, tilt_right or tilt_base");
  std::vector<std::uint8_t> image;
  if (!read_image(words.places[0], image)) return kRefused;
  return update_node(*words.bus, static_cast<contract::Node>(row - contract::kNodes.begin()), image, words.force);
}

struct Verb {
  std::string_view name;
  std::string_view options;  // each followed by a space
  int (*run)(const Words&);
};
constexpr Verb kVerbs[] = {{"pack", "--simulated ", &pack},
                           {"show", "--json ", &show},
                           {"list", "--bus --json ", &list},
                           {"update", "--bus --node --force ", &update}};

}  // namespace

int run_firmware(std::span<const std::string_view> arguments) {
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    std::fputs(kFirmwareHelp, arguments.empty() ? stderr : stdout);
    return arguments.empty() ? kBadUsage : kDone;
  }
  for (const Verb& verb : kVerbs) {
    if (verb.name != arguments[0]) continue;
    if (arguments.size() > 1 && arguments[1] == "--help") {
      std::fputs(kFirmwareHelp, stdout);
      return kDone;
    }
    Words words;
    if (const std::string why = read_words(arguments.subspan(1), verb.options, words); !why.empty()) return bad_usage(why);
    return verb.run(words);
  }
  return bad_usage("there is no \"" + std::string(arguments[0]) + '"');
}

}  // namespace hoist::tool
