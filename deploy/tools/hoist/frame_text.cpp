#include "deploy/tools/hoist/frame_text.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace hoist::tool {

void print_frame_text(double time_s, const bus::LogEntry& entry, const bus::DecodedFrame& frame) {
  const char* direction = entry.direction == bus::Direction::sent ? "sent" : entry.direction == bus::Direction::received ? "    " : "";
  std::printf("%12.6f %s %03X %-24s", time_s, direction, entry.frame.id, frame.name.empty() ? "unknown" : frame.name.c_str());
  if (frame.name.empty())
    for (std::size_t i = 0; i < entry.frame.dlc; ++i) std::printf(" %02X", entry.frame.data[i]);
  for (const bus::DecodedField& field : frame.fields) {
    if (field.hex)
      std::printf(" %s=%llXh", field.name.c_str(), static_cast<unsigned long long>(field.value));
    else
      std::printf(" %s=%.10g", field.name.c_str(), field.value);
    if (!field.unit.empty()) std::printf(" %s", field.unit.c_str());
    if (!field.meaning.empty()) std::printf(" (%s)", field.meaning.c_str());
  }
  if (!frame.problem.empty()) std::printf(" REFUSED: %s", frame.problem.c_str());
  std::putchar('\n');
}

void print_frame_json(double time_s, const bus::LogEntry& entry, const bus::DecodedFrame& frame) {
  nlohmann::ordered_json line{{"time_s", time_s}, {"id", entry.frame.id}, {"name", nullptr}};
  if (!frame.name.empty()) line["name"] = frame.name;
  if (entry.direction != bus::Direction::unknown) line["sent"] = entry.direction == bus::Direction::sent;
  nlohmann::ordered_json fields = nlohmann::ordered_json::object(), words = nlohmann::ordered_json::object();
  for (const bus::DecodedField& field : frame.fields) {
    // What is no number (a damaged float) has no JSON.
    fields[field.name] = std::isfinite(field.value) ? nlohmann::ordered_json(field.value) : nlohmann::ordered_json(nullptr);
    if (!field.meaning.empty()) words[field.name] = field.meaning;
  }
  line["fields"] = fields;
  if (!words.empty()) line["words"] = words;
  if (!frame.problem.empty()) line["problem"] = frame.problem;
  std::printf("%s\n", line.dump().c_str());
}

}  // namespace hoist::tool
