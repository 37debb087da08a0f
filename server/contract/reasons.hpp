// The rows of reasons.def.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace hoist::server {

enum class Reason : std::uint8_t {
#define HOIST_REASON(name, text_en, text_de) name,
#include "server/contract/reasons.def"
#undef HOIST_REASON
};

struct ReasonInfo {
  std::string_view name, text_en, text_de;
};
inline constexpr std::array kReasons{
#define HOIST_REASON(name, text_en, text_de) ReasonInfo{#name, text_en, text_de},
#include "server/contract/reasons.def"
#undef HOIST_REASON
};

constexpr std::string_view reason_name(Reason reason) { return kReasons[static_cast<std::size_t>(reason)].name; }

}  // namespace hoist::server
