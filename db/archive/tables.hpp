// What of a session goes into the archive: its tables, with the columns that mean the same on every hoist. Numbers that
// only one file knows (session, chunk, actor) are left out.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "db/codec/bytes.hpp"

namespace hoist::db {

enum class Kind : std::uint8_t { integer, real, text, blob };

struct ArchiveColumn {
  std::string_view name;
  Kind kind;
};

/// A table whose rows belong to one session. The archive's table has the same name and columns, and `session_id`.
struct ArchiveTable {
  std::string_view name;
  std::span<const ArchiveColumn> columns;
  std::string_view order;  ///< the column that orders a session's rows
  bool changeable;         ///< people may edit its rows after the recording
  bool has_actor;          ///< the actor's words stand in the archive's row; a hoist's file has a row of `actors`
};

/// One value of a row. monostate is NULL.
using Value = std::variant<std::monostate, std::int64_t, double, std::string, Bytes>;
using Row = std::vector<Value>;

namespace archive_columns {
inline constexpr std::array kChunks{ArchiveColumn{"first_tick", Kind::integer},
                                    ArchiveColumn{"last_tick", Kind::integer},
                                    ArchiveColumn{"first_time_ns", Kind::integer},
                                    ArchiveColumn{"last_time_ns", Kind::integer},
                                    ArchiveColumn{"samples", Kind::integer},
                                    ArchiveColumn{"directory", Kind::blob},
                                    ArchiveColumn{"body", Kind::blob}};
inline constexpr std::array kBusChunks{ArchiveColumn{"first_frame", Kind::integer}, ArchiveColumn{"frames", Kind::integer},
                                       ArchiveColumn{"first_time_ns", Kind::integer}, ArchiveColumn{"last_time_ns", Kind::integer},
                                       ArchiveColumn{"body", Kind::blob}};
inline constexpr std::array kJournalChunks{ArchiveColumn{"first_step", Kind::integer}, ArchiveColumn{"steps", Kind::integer},
                                           ArchiveColumn{"body", Kind::blob}};
inline constexpr std::array kCoreImages{ArchiveColumn{"step", Kind::integer}, ArchiveColumn{"tick", Kind::integer},
                                        ArchiveColumn{"bytes", Kind::integer}, ArchiveColumn{"body", Kind::blob}};
inline constexpr std::array kGaps{ArchiveColumn{"number", Kind::integer}, ArchiveColumn{"stream", Kind::text},
                                  ArchiveColumn{"from_tick", Kind::integer}, ArchiveColumn{"to_tick", Kind::integer},
                                  ArchiveColumn{"reason", Kind::text}};
inline constexpr std::array kEvents{
    ArchiveColumn{"number", Kind::integer},   ArchiveColumn{"tick", Kind::integer},    ArchiveColumn{"time_ns", Kind::integer},
    ArchiveColumn{"kind", Kind::integer},     ArchiveColumn{"kind_name", Kind::text},  ArchiveColumn{"code", Kind::integer},
    ArchiveColumn{"bits", Kind::integer},     ArchiveColumn{"item", Kind::integer},    ArchiveColumn{"value", Kind::real},
    ArchiveColumn{"before", Kind::real},      ArchiveColumn{"name", Kind::text},       ArchiveColumn{"request_id", Kind::integer},
    ArchiveColumn{"actor_user", Kind::text},  ArchiveColumn{"actor_role", Kind::text}, ArchiveColumn{"actor_origin", Kind::text},
    ArchiveColumn{"actor_client", Kind::text}};
inline constexpr std::array kMarkers{
    ArchiveColumn{"number", Kind::integer},  ArchiveColumn{"tick", Kind::integer},      ArchiveColumn{"utc_ns", Kind::integer},
    ArchiveColumn{"text", Kind::text},       ArchiveColumn{"kind", Kind::text},         ArchiveColumn{"actor_user", Kind::text},
    ArchiveColumn{"actor_role", Kind::text}, ArchiveColumn{"actor_origin", Kind::text}, ArchiveColumn{"actor_client", Kind::text}};
inline constexpr std::array kUtcAnchors{ArchiveColumn{"time_ns", Kind::integer}, ArchiveColumn{"utc_ns", Kind::integer}};
inline constexpr std::array kParameters{ArchiveColumn{"position", Kind::integer}, ArchiveColumn{"name", Kind::text},
                                        ArchiveColumn{"value", Kind::real}};
inline constexpr std::array kNodePrograms{ArchiveColumn{"position", Kind::integer}, ArchiveColumn{"name", Kind::text},
                                          ArchiveColumn{"product", Kind::integer},  ArchiveColumn{"revision", Kind::integer},
                                          ArchiveColumn{"version", Kind::integer},  ArchiveColumn{"crc", Kind::integer}};
inline constexpr std::array kColumnLayout{ArchiveColumn{"position", Kind::integer}, ArchiveColumn{"name", Kind::text},
                                          ArchiveColumn{"unit", Kind::text},        ArchiveColumn{"type", Kind::text},
                                          ArchiveColumn{"lsb", Kind::real},         ArchiveColumn{"decimals", Kind::integer}};
/// Of the table `sessions`: what was recorded …
inline constexpr std::array kSession{ArchiveColumn{"started_utc_ns", Kind::integer},
                                     ArchiveColumn{"start_time_ns", Kind::integer},
                                     ArchiveColumn{"core_start_time_ns", Kind::integer},
                                     ArchiveColumn{"simulated", Kind::integer},
                                     ArchiveColumn{"layout_hash", Kind::integer},
                                     ArchiveColumn{"software_version", Kind::text},
                                     ArchiveColumn{"core_version", Kind::text},
                                     ArchiveColumn{"ended_utc_ns", Kind::integer},
                                     ArchiveColumn{"close_reason", Kind::text},
                                     ArchiveColumn{"sample_count", Kind::integer},
                                     ArchiveColumn{"first_time_ns", Kind::integer},
                                     ArchiveColumn{"last_time_ns", Kind::integer},
                                     ArchiveColumn{"hoist_id", Kind::text},
                                     ArchiveColumn{"columns_hash", Kind::integer}};
/// … and what people may change afterwards.
inline constexpr std::array kDescription{ArchiveColumn{"note", Kind::text}, ArchiveColumn{"exercise", Kind::text}};
}  // namespace archive_columns

/// Many sessions share one layout of columns: its rows belong to the session's `columns_hash`.
inline constexpr ArchiveTable kLayoutTable{"column_layout", archive_columns::kColumnLayout, "position", false, false};
inline constexpr std::array kSessionTables{
    ArchiveTable{"chunks", archive_columns::kChunks, "first_tick", false, false},
    ArchiveTable{"bus_chunks", archive_columns::kBusChunks, "first_frame", false, false},
    ArchiveTable{"journal_chunks", archive_columns::kJournalChunks, "first_step", false, false},
    ArchiveTable{"core_images", archive_columns::kCoreImages, "step", false, false},
    ArchiveTable{"gaps", archive_columns::kGaps, "number", false, false},
    ArchiveTable{"events", archive_columns::kEvents, "number", false, true},
    ArchiveTable{"utc_anchors", archive_columns::kUtcAnchors, "time_ns", false, false},
    ArchiveTable{"parameters", archive_columns::kParameters, "position", false, false},
    ArchiveTable{"node_programs", archive_columns::kNodePrograms, "position", false, false},
    ArchiveTable{"markers", archive_columns::kMarkers, "number", true, true},
};

}  // namespace hoist::db
