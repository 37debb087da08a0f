// Service data: the SDO server with its domains, the SDO client, and the parameters that a node finds in its flash.
#include <algorithm>
#include <array>

#include "control/bus/sdo_client.hpp"
#include "firmware/lib/parameter_store.hpp"
#include "firmware/lib/sdo_server.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {

using contract::CanFrame;
using contract::canopen::SdoAbort;

constexpr std::size_t kDomainMax = 100;

// A value, a text and a domain; counts what the server makes of the requests.
struct Shelf {
  std::size_t domain = 0;
  int begun = 0, over = 0;
  bool open = false;

  SdoAbort sdo_read(std::uint16_t index, std::uint8_t, firmware::SdoSource& source) {
    if (index == 0x1008)
      source.text = "a text of some length";
    else
      source.raw = 7, source.raw_bytes = 4;
    return index == 0x1008 || index == 0x2000 ? SdoAbort::none : SdoAbort::no_object;
  }
  SdoAbort sdo_target(std::uint16_t index, std::uint8_t, firmware::SdoTarget& target) {
    if (index == 0x2000) target.bytes = 2;
    return index == 0x2000 || index == 0x1F50 ? SdoAbort::none : SdoAbort::no_object;
  }
  SdoAbort sdo_write(std::uint16_t, std::uint8_t, std::uint32_t raw) {
    must(raw <= 0xFFFF, "a value of two bytes has no more");
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_begin(std::uint16_t, std::uint8_t, std::uint32_t told) {
    must(!open, "one transfer at a time");
    if (told > kDomainMax) return SdoAbort::too_long;
    open = true;
    ++begun;
    domain = 0;
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_data(Bytes bytes) {
    must(open && !bytes.empty() && bytes.size() <= firmware::kSdoSegmentBytes, "data belong to a transfer");
    if (domain + bytes.size() > kDomainMax) return SdoAbort::too_long;
    domain += bytes.size();
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_end() {
    must(open, "what ends had begun");
    if (domain % 2 != 0) return SdoAbort::transfer;  // some transfers are refused at their very end
    close();
    return SdoAbort::none;
  }
  void sdo_domain_cancel() {
    must(open, "what is cancelled had begun");
    close();
  }
  void close() {
    open = false;
    ++over;
  }
};

Input frames(std::initializer_list<std::array<std::uint8_t, 8>> all) {
  Input input;
  for (const auto& frame : all) {
    input.push_back(8);
    input.insert(input.end(), frame.begin(), frame.end());
  }
  return input;
}

CanFrame next_frame(Pieces& pieces, std::uint32_t id, std::uint8_t head) {
  CanFrame frame{id, static_cast<std::uint8_t>(head % 9), 0, {}};
  const Bytes data = pieces.take(frame.dlc);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

struct Pages {
  static constexpr std::size_t kPageBytes = 512;
  std::array<std::array<std::byte, kPageBytes>, 2> bytes{};
  bool erase(int page) {
    bytes[static_cast<std::size_t>(page)].fill(std::byte{0xFF});
    return true;
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> part) {
    must(offset % 256 == 0 && part.size() % 256 == 0 && offset + part.size() <= kPageBytes, "flash is written in its blocks");
    std::copy(part.begin(), part.end(), bytes[static_cast<std::size_t>(page)].begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }
  std::span<const std::byte> read(int page) const { return bytes[static_cast<std::size_t>(page)]; }
};

}  // namespace

void fuzz_sdo_server(Bytes input) {
  Shelf shelf;
  firmware::SdoServer server(1);
  Pieces pieces(input);
  while (!pieces.empty()) {
    const std::uint8_t head = pieces.u8();
    if (head >= 0xF0) {  // time passes
      for (int i = 0; i < 100 * (head - 0xEF); ++i) server.tick_1ms(shelf);
      server.answer_sent();
      continue;
    }
    const CanFrame frame = next_frame(pieces, 0x601, head);
    server.answer_sent();
    server.on_request(frame, shelf);
    const bool is_abort = frame.dlc == 8 && frame.data[0] == contract::canopen::kSdoAbort;
    must(server.answer_waiting() != is_abort, "one answer to each request, none to an abort");
    must(is_abort || (server.answer().dlc == 8 && server.answer().id == 0x581), "an answer is eight bytes with the node's id");
  }
  server.reset(shelf);
  must(!shelf.open && shelf.begun == shelf.over, "every transfer that began is over");
}
std::vector<Input> seeds_sdo_server() {
  return {frames({{0x40, 0x08, 0x10, 0}, {0x60}, {0x70}, {0x60}}),
          frames({{0x2B, 0x00, 0x20, 0, 5, 0}, {0x21, 0x00, 0x20, 0, 2}, {0x0B, 1, 2}, {0x40, 0x00, 0x20, 0}}),
          frames({{0x21, 0x50, 0x1F, 1, 10}, {0x00, 1, 2, 3, 4, 5, 6, 7}, {0x19, 8, 9, 10}, {0x80, 0x50, 0x1F, 1}})};
}

void fuzz_sdo_client(Bytes input) {
  Pieces pieces(input);
  const std::uint8_t kind = pieces.u8();
  std::array<std::uint8_t, 20> content{};
  bus::SdoClient client;
  const bool asked = kind % 3 == 0   ? client.upload(1, 0x1008, 0)
                     : kind % 3 == 1 ? client.download(1, 0x1008, 0, content)
                                     : client.download(1, 0x1008, 0, Bytes(content).first(2));
  must(asked, "what can be asked is asked");
  std::uint64_t now_ns = 0, last_ns = 0;
  bool sent = false;
  // Every answer may start one more segment, every timeout one more try: both are bounded by the input.
  for (int steps = 0; steps < 20000; ++steps) {
    now_ns += 1'000'000;
    if (const auto request = client.step(now_ns)) {
      must(request->id == 0x601 && request->dlc == 8, "a request is eight bytes to its node");
      must(!sent || now_ns - last_ns >= 4'300'000, "requests keep their pace");
      sent = true;
      last_ns = now_ns;
      if (!pieces.empty()) client.on_frame(next_frame(pieces, 0x581, pieces.u8()));
    }
    must(client.uploaded().size() <= bus::SdoClient::kUploadMax && client.confirmed() <= content.size(), "nothing grows beyond its place");
    if (client.outcome() != bus::SdoClient::Outcome::busy && steps % 8 == 7) return;
  }
  must(false, "a transfer ends");
}
std::vector<Input> seeds_sdo_client() {
  Input upload = frames({{0x41, 0x08, 0x10, 0, 9}, {0x00, 1, 2, 3, 4, 5, 6, 7}, {0x1B, 8, 9}});
  Input download = frames({{0x60, 0x08, 0x10, 0}, {0x20}, {0x30}, {0x20}});
  Input expedited = frames({{0x60, 0x08, 0x10, 0}});
  upload.insert(upload.begin(), 0);
  download.insert(download.begin(), 1);
  expedited.insert(expedited.begin(), 2);
  return {upload, download, expedited};
}

void fuzz_parameter_store(Bytes input) {
  Pages pages;
  for (int page = 0; page < 2; ++page) {
    pages.erase(page);
    const Bytes half = page == 0 ? input.first(input.size() / 2) : input.subspan(input.size() / 2);
    for (std::size_t i = 0; i < std::min(half.size(), Pages::kPageBytes); ++i)
      pages.bytes[static_cast<std::size_t>(page)][i] = std::byte{half[i]};
  }
  firmware::ParameterStore store(pages, 1);
  std::size_t found = 0;
  const auto state = store.load([&](const firmware::StoredValue&) { ++found; });
  must(found <= Pages::kPageBytes / firmware::kStoreRecordBytes, "no more records than a page holds");
  must(state == firmware::StoreState::good || found == 0, "what is no good copy gives nothing");
  must(store.save(3,
                  [](std::size_t i) {
                    return firmware::StoredValue{static_cast<std::uint16_t>(i), 1, 4, 42};
                  }),
       "a save works whatever was there");
  std::uint32_t sum = 0;
  must(store.load([&](const firmware::StoredValue& value) { sum += value.raw + value.index; }) == firmware::StoreState::good && sum == 129,
       "what was saved is read");
}
std::vector<Input> seeds_parameter_store() {
  Pages pages;
  pages.erase(0);
  pages.erase(1);
  firmware::ParameterStore store(pages, 1);
  for (int i = 0; i < 2; ++i)
    must(store.save(20, [](std::size_t at) { return firmware::StoredValue{static_cast<std::uint16_t>(at), 0, 2, 7}; }), "a seed is saved");
  Input input;
  for (const auto& page : pages.bytes)
    for (const std::byte byte : page) input.push_back(std::to_integer<std::uint8_t>(byte));
  return {input, {}};
}

}  // namespace hoist::fuzz
