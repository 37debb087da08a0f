// Stored and sent data: chunks of the database, the parameter file, frames and requests of a browser, questions to the simulator.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "control/run/parameter_file.hpp"
#include "db/codec/bus_chunk.hpp"
#include "db/codec/column_chunk.hpp"
#include "firmware/sim/requests.hpp"
#include "server/http/exchange.hpp"
#include "server/text/json_text.hpp"
#include "server/ws/frame.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {

// Two blobs in one input: length of the first in two bytes.
Input two_blobs(const db::Bytes& first, const db::Bytes& second) {
  Input input{static_cast<std::uint8_t>(first.size()), static_cast<std::uint8_t>(first.size() >> 8)};
  input.insert(input.end(), first.begin(), first.end());
  input.insert(input.end(), second.begin(), second.end());
  return input;
}

std::string masked(server::Opcode opcode, std::string_view payload) {
  std::string frame;
  frame += static_cast<char>(0x80U | static_cast<unsigned>(opcode));
  frame += static_cast<char>(0x80U | payload.size());
  frame.append("\x11\x22\x33\x44", 4);
  for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ "\x11\x22\x33\x44"[i % 4]);
  return frame;
}

}  // namespace

void fuzz_column_chunk(Bytes input) {
  Pieces pieces(input);
  const auto first = static_cast<std::size_t>(pieces.number(2));
  const Bytes directory_blob = pieces.take(first);
  const Bytes body = pieces.take(input.size());
  db::ChunkDirectory directory;
  if (db::parse_directory(directory_blob, directory) != db::CodecError::none) return;
  must(directory.samples <= db::kMaxChunkSamples && directory.columns.size() <= db::kMaxChunkColumns, "a directory keeps the limits");
  db::ChunkDecoder decoder;
  std::vector<std::int64_t> values;
  for (std::size_t column = 0; column < directory.columns.size(); ++column) {
    const db::ChunkColumn& at = directory.columns[column];
    Bytes payload = body;
    if (directory.layout == db::ChunkLayout::frame_per_column) {
      if (at.offset > body.size() || at.bytes > body.size() - at.offset) continue;
      payload = body.subspan(at.offset, at.bytes);
    }
    if (decoder.column(directory, column, payload, values) == db::CodecError::none)
      must(values.size() == directory.samples, "a column has as many values as its directory says");
  }
}
std::vector<Input> seeds_column_chunk() {
  std::vector<Input> seeds;
  for (const auto layout : {db::ChunkLayout::one_frame, db::ChunkLayout::frame_per_column}) {
    std::vector<std::vector<std::int64_t>> columns(4);
    for (std::int64_t i = 0; i < 120; ++i) {
      columns[0].push_back(1000 + i);
      columns[1].push_back(7);
      columns[2].push_back((i * i * 31) % 977 - 400);
      columns[3].push_back(i % 2 == 0 ? INT64_MIN : INT64_MAX);
    }
    db::ChunkEncoder encoder;
    db::EncodedChunk chunk;
    must(encoder.encode(columns, 120, layout, chunk) == db::CodecError::none, "a good chunk encodes");
    seeds.push_back(two_blobs(chunk.directory, chunk.body));
  }
  return seeds;
}

void fuzz_bus_chunk(Bytes input) {
  std::vector<contract::BusRecord> frames;
  if (db::decode_bus(input, frames) != db::CodecError::none) return;
  must(!frames.empty() && frames.size() <= db::kMaxBusChunkFrames, "a chunk of frames keeps the limits");
}
std::vector<Input> seeds_bus_chunk() {
  std::vector<contract::BusRecord> frames;
  for (std::uint64_t i = 0; i < 60; ++i)
    frames.push_back(
        {1'000'000'000 + i * 1'000'000, static_cast<std::uint32_t>(0x180 + i % 5), 8, 0, static_cast<std::uint8_t>(i % 2), 0, i * 0x0101});
  db::Bytes blob;
  must(db::encode_bus(frames, blob) == db::CodecError::none, "good frames encode");
  return {blob};
}

void fuzz_parameter_file(Bytes input) {
  // A file that exists only in memory: the loader takes a path.
  static const int file = ::memfd_create("parameters", MFD_CLOEXEC);
  must(file >= 0 && ::ftruncate(file, 0) == 0, "a file in memory can be made");
  must(::pwrite(file, input.data(), input.size(), 0) == static_cast<ssize_t>(input.size()), "it takes the input");
  const run::LoadedParams loaded = run::load_parameter_file("/proc/self/fd/" + std::to_string(file));
  must(loaded.usable || !loaded.problem.empty(), "a file that is not used has a reason");
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    must(contract::check_param(i, contract::get_param(loaded.params, i)) == contract::ParamCheck::ok, "no parameter leaves its range");
}
std::vector<Input> seeds_parameter_file() {
  char name[] = "/tmp/hoist-fuzz-XXXXXX";
  const int file = ::mkstemp(name);
  must(file >= 0, "a temporary file can be made");
  must(run::save_parameter_file(name, contract::Params{}).problem.empty(), "the defaults can be saved");
  Input saved(16384);
  std::FILE* stream = std::fopen(name, "rb");
  saved.resize(stream == nullptr ? 0 : std::fread(saved.data(), 1, saved.size(), stream));
  if (stream != nullptr) std::fclose(stream);
  ::close(file);
  ::unlink(name);
  return {saved, input_of(R"({"values":{},"checksum":"0"})"), input_of(R"({"values":[],"checksum":1})"), input_of("[[[[[[[[[[")};
}

void fuzz_websocket_frames(Bytes input) {
  const auto run = [input](std::size_t piece) {
    server::FrameReader reader;
    std::vector<server::Incoming> messages;
    std::string seen;
    const std::string_view bytes(reinterpret_cast<const char*>(input.data()), input.size());
    bool good = true;
    for (std::size_t at = 0; at < bytes.size() && good; at += piece) good = reader.feed(bytes.substr(at, piece), messages);
    for (const server::Incoming& one : messages) {
      must(one.payload.size() <= server::kMessageLimit_bytes, "no message is longer than the limit");
      must(one.kind != server::Incoming::Kind::text || server::valid_utf8(one.payload), "text is UTF-8");
      seen += static_cast<char>('0' + static_cast<int>(one.kind));
      seen += one.payload;
    }
    return seen + (good ? '+' : '-');
  };
  const std::string whole = run(input.size() + 1);
  must(whole == run(1), "how the stream is cut does not matter");
}
std::vector<Input> seeds_websocket_frames() {
  return {input_of(masked(server::Opcode::text, R"({"type":"ping"})") + masked(server::Opcode::ping, "x") +
                   masked(server::Opcode::close, "\x03\xe8")),
          input_of("\x01\x81\x11\x22\x33\x44z" + masked(server::Opcode::continuation, "rest"))};
}

// The same bytes as target, as body, and as header fields, one "name:value" per line.
void fuzz_request_text(Bytes input) {
  const std::string text(reinterpret_cast<const char*>(input.data()), input.size());
  server::Request request;
  if (server::parse_target(text, request)) {
    must(request.path.starts_with('/') && request.path.find('\0') == std::string::npos, "a path is absolute and has no zero byte");
    must(request.query.size() <= server::kQueryFieldLimit, "a query keeps its limit");
  }
  server::JsonError error;
  if (server::parse_json(text, error)) {
    must(text.find('\0') == std::string::npos, "a zero byte is no JSON");
    (void)server::repeated_name(text);
    must(!server::parse_json(text + "x", error) && !server::parse_json(text + '\0', error), "nothing follows a value");
  }
  server::HeaderFields fields;
  for (std::size_t at = 0; at < text.size() && fields.size() < 100;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    const std::size_t colon = std::min(line.find(':'), line.size());
    fields.emplace_back(line.substr(0, colon), colon < line.size() ? line.substr(colon + 1) : "");
    at = end + 1;
  }
  must(server::header_fault(fields, false).empty() || !server::header_fault(fields, true).empty(),
       "what HTTP/1.1 refuses, HTTP/1.0 does, too");
  fields.insert(fields.end(), {{"host", "a"}, {"host", "a"}});
  must(!server::header_fault(fields, false).empty(), "two hosts are never accepted");
}
std::vector<Input> seeds_request_text() {
  return {input_of("/api/v1/sessions/1/export?format=csv&limit=%31"),
          input_of(R"({"type": "drive", "held": true, "values": {"a": [1, -2e3]}})"),
          input_of("host:127.0.0.1\ncontent-length:12\ntransfer-encoding:chunked\ncookie:a=b")};
}

void fuzz_simulator_request(Bytes input) {
  // One world for all inputs: it is what the requests change, and making one costs more than a request.
  static sim::World world{[] {
    sim::WorldOptions options;
    options.host_in_process = true;
    return options;
  }()};
  const std::string answer = sim::answer_request(world, {}, {reinterpret_cast<const char*>(input.data()), input.size()});
  must(nlohmann::json::accept(answer) && answer.find('\n') == std::string::npos, "an answer is one line of JSON");
  world.advance_1ms();
}
std::vector<Input> seeds_simulator_request() {
  return {input_of(R"({"op":"state"})"),
          input_of(R"({"op":"help"})"),
          input_of(R"({"op":"bumper","which":"front","pressed":true})"),
          input_of(R"({"op":"unplug","node":"tilt_left"})"),
          input_of(R"({"op":"battery","volts":23.5})"),
          input_of(R"({"op":"wish","speed_m_s":0.4})"),
          input_of(R"({"op":"obstacle","x_m":1,"y_m":2,"radius_m":0.2})"),
          input_of(R"({"op":"scenario","name":"square"})"),
          input_of(R"({"op":"power","on":false})"),
          input_of(R"({"op":"reset"})")};
}

}  // namespace hoist::fuzz
