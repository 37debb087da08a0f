// The definitions of the figures in the language of a report.
#pragma once
#include <array>
#include <cstddef>
#include <string_view>

#include "db/metrics/metric_list.hpp"

namespace hoist::db::report {

struct Definition {
  std::string_view key;
  unsigned version;
  std::string_view formula, gate, source;
};

namespace definitions_de {
inline constexpr std::string_view kCompared =
    "eine Übung; ein Gang, begonnen an seiner Marke oder an einer eindeutigen Stelle der Übung; höchstens 0,5 s fehlen";
inline constexpr std::string_view kTurned =
    "eine Übung; ein Gang, begonnen an seiner Marke oder an einer eindeutigen Stelle der Übung; höchstens 0,5 s fehlen; Weg und Becken "
    "haben gedreht";
inline constexpr std::string_view kLap =
    "eine Übung; ein Gang, begonnen an seiner Marke oder an einer eindeutigen Stelle der Übung; höchstens 0,5 s fehlen; eine Runde "
    "gegangen";
inline constexpr std::string_view kStride = "8 gleichmäßige Doppelschritte; Schwanken ab 2 mm, quadratisches Mittel; A(T) ab 0,3 A(0)";
inline constexpr std::string_view kSmooth = "eine Gehphase; die längste dauert höchstens 600 s";
inline constexpr std::string_view kCounted = "höchstens 0,5 s fehlen";
inline constexpr std::string_view kTurns =
    "Drehungen: Drehrate (Richtung über 0,5 s) über 1 °/s in einer Richtung, unter 0,3 s überbrückt, mit einer Spitze über 15 °/s und mehr "
    "als 45°";
inline constexpr std::string_view kTask =
    "eine Wiederholung einer solchen Aufgabe, von ihrer Startmarke bis zu ihrem Ende; ein Gang; höchstens 0,5 s fehlen";
inline constexpr std::string_view kPhase =
    "eine Wiederholung einer solchen Aufgabe, von ihrer Startmarke bis zu ihrem Ende; ein Gang; höchstens 0,5 s fehlen; vor dem Ende um "
    "160 Grad gedreht";
inline constexpr std::string_view kLed = "der Patient hat geführt; Einstellungen seit Beginn der Sitzung nicht geändert";
inline constexpr std::array kAll{
#define HOIST_DEFINITION_DE(key, version, formula, gate, source) Definition{#key, version, formula, gate, source},
#include "db/report/definitions_de.def"
#undef HOIST_DEFINITION_DE
};
// Where its row is; the number of rows when there is none. A number, as g++ with sanitizers takes no comparison of such an address as constant.
constexpr std::size_t find(const MetricInfo& metric) {
  std::size_t i = 0;
  while (i < kAll.size() && kAll[i].key != metric.key) ++i;
  return i < kAll.size() && kAll[i].version == metric.version && kAll[i].gate.empty() == metric.gate.empty() ? i : kAll.size();
}
static_assert(contract::all_rows(kMetrics, [](const MetricInfo& metric) { return find(metric) < kAll.size(); }),
              "definitions_de.def: a figure has no row, or one of another version");
}  // namespace definitions_de

constexpr Definition definition(const MetricInfo& metric, bool german) {
  return german ? definitions_de::kAll[definitions_de::find(metric)]
                : Definition{metric.key, metric.version, metric.formula, metric.gate, metric.source};
}

}  // namespace hoist::db::report
