// The rows of notices.def.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace hoist::server {

enum class NoticeName : std::uint8_t {
#define HOIST_NOTICE(name, priority, text_en, action_en, text_de, action_de) name,
#include "server/contract/notices.def"
#undef HOIST_NOTICE
};

struct NoticeInfo {
  std::string_view name, priority, text_en, action_en, text_de, action_de;
};
inline constexpr std::array kNotices{
#define HOIST_NOTICE(name, priority, text_en, action_en, text_de, action_de) \
  NoticeInfo{#name, #priority, text_en, action_en, text_de, action_de},
#include "server/contract/notices.def"
#undef HOIST_NOTICE
};

}  // namespace hoist::server
