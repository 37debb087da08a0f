// The rows of formats.def, the files that several sessions make together, and what can be chosen for an export.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hoist::db {

enum class ExportFormat : std::uint8_t {
#define HOIST_EXPORT(name, ...) name,
#include "db/export/formats.def"
#undef HOIST_EXPORT
};
enum class ExportDelivery : std::uint8_t { streamed, whole };
enum class ExportColumns : std::uint8_t { chosen, all };

struct ExportFormatInfo {
  ExportFormat format;
  std::string_view name, media_type;
  std::string_view ending;  ///< of the file's name
  ExportDelivery delivery;
  ExportColumns columns;
  std::string_view title_en, title_de, doc;
};
inline constexpr std::array kExportFormats{
#define HOIST_EXPORT(name, media_type, ending, delivery, columns, title_en, title_de, doc)         \
  ExportFormatInfo{ExportFormat::name,     #name,    media_type, ending, ExportDelivery::delivery, \
                   ExportColumns::columns, title_en, title_de,   doc},
#include "db/export/formats.def"
#undef HOIST_EXPORT
};
struct ExportOptions {
  ExportFormat format = ExportFormat::csv;
  std::vector<std::string> columns = {};  ///< these in this order; empty = all
  bool comments = true;                   ///< csv, csv_de and events: the '#' lines
  bool constant = true;                   ///< also the columns that hold one value all the time
};

constexpr const ExportFormatInfo& export_format_info(ExportFormat format) { return kExportFormats[static_cast<std::size_t>(format)]; }
constexpr std::optional<ExportFormat> find_export_format(std::string_view name) {
  for (const ExportFormatInfo& info : kExportFormats)
    if (info.name == name) return info.format;
  return std::nullopt;
}

namespace detail {
#define HOIST_EXPORT(name, ...) "|" #name
inline constexpr std::string_view kBarAndNames =
#include "db/export/formats.def"
    ;
#undef HOIST_EXPORT
#define HOIST_EXPORT(name, media_type, ending, delivery, columns, title_en, title_de, doc) "; " #name ": " doc
inline constexpr std::string_view kMarkAndDocs =
#include "db/export/formats.def"
    ;
#undef HOIST_EXPORT
}  // namespace detail
/// "csv|events|…"
inline constexpr std::string_view kExportFormatNames = detail::kBarAndNames.substr(1);
/// "csv: all samples as CSV; …"
inline constexpr std::string_view kExportFormatDocs = detail::kMarkAndDocs.substr(2);

enum class BundleLayout : std::uint8_t { files, bids, sqlite, reports };
struct BundleLayoutInfo {
  BundleLayout layout;
  std::string_view name, file_name, media_type;
};
inline constexpr std::array kBundleLayouts{
    BundleLayoutInfo{BundleLayout::files, "files", "hoist_sessions.zip", "application/zip"},
    BundleLayoutInfo{BundleLayout::bids, "bids", "hoist_bids.zip", "application/zip"},
    BundleLayoutInfo{BundleLayout::sqlite, "sqlite", "hoist_sessions.sqlite", "application/vnd.sqlite3"},
    BundleLayoutInfo{BundleLayout::reports, "reports", "hoist_reports.zip", "application/zip"},
};
constexpr const BundleLayoutInfo& bundle_layout_info(BundleLayout layout) { return kBundleLayouts[static_cast<std::size_t>(layout)]; }
constexpr std::optional<BundleLayout> find_bundle_layout(std::string_view name) {
  for (const BundleLayoutInfo& info : kBundleLayouts)
    if (info.name == name) return info.layout;
  return std::nullopt;
}

}  // namespace hoist::db
