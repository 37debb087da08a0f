// The console's view of the tables: types and descriptions, and the reading of one tick record from the wire.
#include <cmath>
#include <string>

#include "control/contract/alarms.hpp"
#include "control/contract/emergencies.hpp"
#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "db/export/formats.hpp"
#include "db/metrics/metric_list.hpp"
#include "deploy/tools/gen/generate.hpp"
#include "server/contract/topics.hpp"

namespace hoist::gen {

std::string quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out + "'";
}

std::string words(std::string_view english, std::string_view german) {
  return "{ en: " + quoted(english) + ", de: " + quoted(german) + " }";
}

namespace {

using namespace hoist::contract;

template <typename Rows>
std::string name_union(std::string_view type, const Rows& rows) {
  std::string out = "export type " + std::string(type) + " =";
  for (const auto& row : rows) out += "\n  | " + quoted(row.name);
  return out + ";\n";
}

std::string head(std::string_view table) { return "// " + made_from(table) + "\n\n"; }

constexpr std::string_view kWords = "export interface Words {\n  en: string;\n  de: string;\n}\n\n";

std::string_view edit_name(EditRule edit) { return edit == EditRule::live ? "live" : "stopped"; }
std::string_view scope_name(ParamScope scope) {
  switch (scope) {
    case ParamScope::drive:
      return "drive";
    case ParamScope::tilt:
      return "tilt";
    case ParamScope::core:
      break;
  }
  return "core";
}
std::string_view role_name(Role role) {
  switch (role) {
    case Role::therapist:
      return "therapist";
    case Role::engineer:
      return "engineer";
    case Role::viewer:
      break;
  }
  return "viewer";
}

GeneratedFile params_file() {
  std::string out = head("control/contract/params.def");
  out += kWords;
  out += name_union("ParamName", kParams);
  out += R"(
export interface ParamInfo {
  id: number;
  name: ParamName;
  unit: string;
  min: number;
  default: number;
  max: number;
  /** live: also while moving; stopped: only when the hoist stands still on standby. */
  edit: 'live' | 'stopped';
  scope: 'core' | 'drive' | 'tilt';
  /** Who may change it. */
  role: 'viewer' | 'therapist' | 'engineer';
  source: string;
  title: Words;
  effect: Words;
}

export const params: readonly ParamInfo[] = [
)";
  for (const auto& p : kParams) {
    out += "  {\n    id: " + std::to_string(p.id) + ", name: " + quoted(p.name) + ", unit: " + quoted(p.unit) +
           ", min: " + number_text(p.min) + ", default: " + number_text(p.default_value) + ", max: " + number_text(p.max) +
           ",\n    edit: " + quoted(edit_name(p.edit)) + ", scope: " + quoted(scope_name(p.scope)) +
           ", role: " + quoted(role_name(p.role)) + ", source: " + quoted(p.source) + ",\n    title: " + words(p.title_en, p.title_de) +
           ",\n    effect: " + words(p.effect_en, p.effect_de) + ",\n  },\n";
  }
  out += R"(];

export interface PresetInfo {
  name: string;
  title: Words;
  doc: Words;
  values: Partial<Record<ParamName, number>>;
}

export const presets: readonly PresetInfo[] = [
)";
  for (const auto& preset : kPresets) {
    out += "  {\n    name: " + quoted(preset.name) + ", title: " + words(preset.title_en, preset.title_de) +
           ",\n    doc: " + words(preset.doc_en, preset.doc_de) + ",\n    values: {";
    for (const auto& value : kPresetValues) {
      if (value.preset == preset.name)
        out += " " + std::string(kParams[param_index(value.param)].name) + ": " + number_text(value.value) + ",";
    }
    out += " },\n  },\n";
  }
  return {"web/src/contract/params.gen.ts", out + "];\n"};
}

std::string_view type_name(SignalType type) {
  switch (type) {
    case SignalType::u64:
      return "u64";
    case SignalType::u32:
      return "u32";
    case SignalType::i32:
      return "i32";
    case SignalType::f32:
      return "f32";
    case SignalType::u16:
      return "u16";
    case SignalType::u8:
      break;
  }
  return "u8";
}

// 64-bit integers become numbers: tick and time stay below 2^53 for 100 days.
std::string read_expression(const SignalInfo& s) {
  const std::string at = "at + " + std::to_string(s.offset);
  switch (s.type) {
    case SignalType::u64:
      return "Number(view.getBigUint64(" + at + ", true))";
    case SignalType::u32:
      return "view.getUint32(" + at + ", true)";
    case SignalType::i32:
      return "view.getInt32(" + at + ", true)";
    case SignalType::f32:
      return "view.getFloat32(" + at + ", true)";
    case SignalType::u16:
      return "view.getUint16(" + at + ", true)";
    case SignalType::u8:
      break;
  }
  return "view.getUint8(" + at + ")";
}

GeneratedFile signals_file() {
  std::string out = head("control/contract/signals.def");
  out += kWords;
  out += name_union("SignalName", kSignals);
  out += R"(
export interface SignalInfo {
  id: number;
  name: SignalName;
  type: 'u64' | 'u32' | 'i32' | 'f32' | 'u16' | 'u8';
  unit: string;
  /** Value of one step of the stored integer in recordings. */
  lsb: number;
  /** Place of the value in a tick record, in bytes. */
  offset: number;
  title: Words;
}

/** Every live value of one control step. */
export type TickRecord = Record<SignalName, number>;

)";
  out += "export const tickRecordBytes = " + std::to_string(sizeof(TickRecord)) + ";\n\n";
  out +=
      "/** Reads the record that begins at byte `at`. */\nexport function readTickRecord(view: DataView, at: number): TickRecord {\n  "
      "return {\n";
  for (const auto& s : kSignals) out += "    " + std::string(s.name) + ": " + read_expression(s) + ",\n";
  out += "  };\n}\n\nexport const signals: readonly SignalInfo[] = [\n";
  for (const auto& s : kSignals) {
    out += "  { id: " + std::to_string(s.id) + ", name: " + quoted(s.name) + ", type: " + quoted(type_name(s.type)) +
           ", unit: " + quoted(s.unit) + ", lsb: " + number_text(s.lsb) + ", offset: " + std::to_string(s.offset) +
           ", title: " + words(s.title_en, s.title_de) + " },\n";
  }
  return {"web/src/contract/signals.gen.ts", out + "];\n"};
}

// hoist.v1's blocks of live values: types, and the reading of each block.
GeneratedFile topics_file() {
  using namespace hoist::server;
  std::string out = head("server/contract/topics.def");
  out += "import type { TopicName } from './rest.gen';\nimport type { SignalName, TickRecord } from './signals.gen';\n\n";
  out +=
      "/** A page made for another table cannot read the samples. */\nexport const topicsHash = " + quoted(hex64(topics_hash())) + ";\n\n";
  out += "/** The live values of each topic. */\nexport interface TopicValues {\n";
  std::string blocks;
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    const auto topic = static_cast<Topic>(i);
    std::string names, reads;
    std::size_t bytes = 0;
    for (const TopicValue& value : kTopicValues) {
      if (value.topic != topic) continue;
      SignalInfo signal = kSignals[*find_signal(value.name)];
      signal.offset = bytes;
      bytes += value.size;
      names += "\n    | " + quoted(value.name);
      reads += "      " + std::string(value.name) + ": " + read_expression(signal) + ",\n";
    }
    out += "  /** " + std::string(kTopics[i].doc) + " */\n  " + std::string(kTopics[i].name) + ":" +
           (topic == Topic::all ? std::string(" SignalName") : names) + ";\n";
    if (topic == Topic::all) continue;
    blocks += "  {\n    name: " + quoted(kTopics[i].name) + ",\n    bytes: " + std::to_string(bytes) + ",\n    read: (view, at) => ({\n" +
              reads + "    }),\n  },\n";
  }
  out +=
      "}\n\nexport interface TopicBlock {\n  name: Exclude<TopicName, 'all'>;\n  bytes: number;\n"
      "  /** Reads the block that begins at byte `at`. */\n  read: (view: DataView, at: number) => Partial<TickRecord>;\n}\n\n"
      "/** The blocks of a sample, in the order of their bits in the header. */\nexport const topicBlocks: readonly TopicBlock[] = [\n";
  return {"web/src/contract/topics.gen.ts", out + blocks + "];\n"};
}

std::string_view priority_name(Priority priority) {
  switch (priority) {
    case Priority::high:
      return "high";
    case Priority::medium:
      return "medium";
    case Priority::low:
      break;
  }
  return "low";
}
std::string_view reaction_name(Reaction reaction) {
  switch (reaction) {
    case Reaction::power_off:
      return "power_off";
    case Reaction::out_of_service:
      return "out_of_service";
    case Reaction::protective_stop:
      return "protective_stop";
    case Reaction::soft_stop:
      return "soft_stop";
    case Reaction::warn:
      break;
  }
  return "warn";
}

std::string alarm_signal(const AlarmInfo& alarm) {
  std::string pulses;
  unsigned at_ms = 0;
  for (unsigned pulse = 0; pulse < alarm.pulses; ++pulse) {
    pulses += (pulse == 0 ? "" : ", ") + std::to_string(at_ms);
    at_ms += alarm.pulse_ms + alarm_gap_ms(alarm, pulse);
  }
  return "  " + std::string(priority_name(alarm.priority)) +
         ": {\n    colour: " + quoted(kAlarmColourNames[static_cast<std::size_t>(alarm.colour)]) + ", pulses_ms: [" + pulses +
         "],\n    pulse_ms: " + std::to_string(alarm.pulse_ms) + ", burst_ms: " + std::to_string(at_ms) +
         ", flash_ms: " + std::to_string(alarm.flash_ms) + ", lit_ms: " + std::to_string(alarm.lit_ms) + ",\n  },\n";
}

GeneratedFile faults_file() {
  std::string out = head("control/contract/faults.def");
  out += kWords;
  out += name_union("FaultName", kFaults) + "\n" + name_union("RefusalName", kRefusals) + "\n" + name_union("ModeName", kModes);
  out += R"(
export interface FaultInfo {
  /** Place in fault_bits: one of 53, which a number holds exactly. */
  bit: number;
  name: FaultName;
  priority: 'high' | 'medium' | 'low';
  reaction: 'warn' | 'soft_stop' | 'protective_stop' | 'out_of_service' | 'power_off';
  text: Words;
  /** What to do next. */
  action: Words;
}

export const faults: readonly FaultInfo[] = [
)";
  for (const auto& f : kFaults) {
    out += "  {\n    bit: " + std::to_string(f.bit) + ", name: " + quoted(f.name) + ", priority: " + quoted(priority_name(f.priority)) +
           ", reaction: " + quoted(reaction_name(f.reaction)) + ",\n    text: " + words(f.text_en, f.text_de) +
           ",\n    action: " + words(f.action_en, f.action_de) + ",\n  },\n";
  }
  out += R"(];

/** What a fault is about, where its code says more than its own row. */
export interface FaultDetail {
  fault: FaultName;
  code: number;
  name: string;
  text: Words;
  action: Words;
}

export const faultDetails: readonly FaultDetail[] = [
)";
  for (const auto& d : kDetails) {
    out += "  {\n    fault: " + quoted(fault_info(d.fault).name) + ", code: " + hex_text(d.code, 4) + ", name: " + quoted(d.name) +
           ",\n    text: " + words(d.text_en, d.text_de) + ",\n    action: " + words(d.action_en, d.action_de) + ",\n  },\n";
  }
  out += R"(];

/** Faults that have a code: the live value <name>_code. */
export const codedFaults = [)";
  for (const auto& f : kFaults)
    if ((faults_with_details() & fault_bit(f)) != 0) out += quoted(f.name) + ", ";
  out.resize(out.size() - 2);
  out += R"(] as const;

/** The effect is a consequence of the cause: shown under it. */
export const explanations: readonly { cause: FaultName; effect: FaultName }[] = [
)";
  for (const auto& e : kExplanations)
    out += "  { cause: " + quoted(fault_info(e.cause).name) + ", effect: " + quoted(fault_info(e.effect).name) + " },\n";
  out += R"(];

/** The patient needs help before the machine does: shown above every other alarm, in this order. */
export const endangers: readonly FaultName[] = [)";
  for (const Fault fault : kEndangers) out += quoted(fault_info(fault).name) + ", ";
  out.resize(out.size() - 2);
  out += R"(];

/** How alarms of a priority sound and flash, here and at the hoist (control/contract/alarms.def, after IEC 60601-1-8). */
export interface AlarmSignal {
  colour: 'cyan' | 'yellow' | 'red';
  /** When each pulse of a burst begins. */
  pulses_ms: readonly number[];
  pulse_ms: number;
  /** From one burst to the next. */
  burst_ms: number;
  /** Period of the light; 0: steady. */
  flash_ms: number;
  lit_ms: number;
}

export const alarmSignals: Readonly<Record<FaultInfo['priority'], AlarmSignal>> = {
)";
  for (const AlarmInfo& alarm : kAlarms) out += alarm_signal(alarm);
  out += "};\n\n/** Pitch of a pulse and the harmonics above it. */\nexport const alarmPitch_hz = " + number_text(kAlarmPitch_hz) +
         ";\nexport const alarmHarmonics = " + std::to_string(kAlarmHarmonics) +
         ";\n\n/** How long sound is paused at the most. */\nexport const audioPause_s = " + number_text(kAudioPause_s) + ";\n";
  out += R"(
export interface RefusalInfo {
  /** Place in blocked_bits. */
  bit: number;
  name: RefusalName;
  text: Words;
}

export const refusals: readonly RefusalInfo[] = [
)";
  for (const auto& r : kRefusals) {
    out += "  { bit: " + std::to_string(r.bit) + ", name: " + quoted(r.name) + ", text: " + words(r.text_en, r.text_de) + " },\n";
  }
  out += R"(];

/** Why the hoist goes more slowly than it is asked to, by the value of speed_cause. */
export const speedCauses: readonly { value: number; name: string; text: Words }[] = [
)";
  for (const auto& c : kSpeedCauses)
    out += "  { value: " + std::to_string(c.value) + ", name: " + quoted(c.name) + ", text: " + words(c.text_en, c.text_de) + " },\n";
  out += R"(];

export interface ModeInfo {
  value: number;
  name: ModeName;
  /** The wheels may turn in this mode. */
  moving: boolean;
  title: Words;
}

export const modes: readonly ModeInfo[] = [
)";
  for (const auto& m : kModes) {
    out += "  { value: " + std::to_string(m.value) + ", name: " + quoted(m.name) + ", moving: " + (m.moving ? "true" : "false") +
           ", title: " + words(m.title_en, m.title_de) + " },\n";
  }
  return {"web/src/contract/faults.gen.ts", out + "];\n"};
}

GeneratedFile emergencies_file() {
  std::string out = head("control/contract/emergencies.def");
  out += R"(import type { Words } from './faults.gen';

export interface EmergencyInfo {
  code: number;
  /** Bits of the code that count; of all rows that fit, the first one is meant. The last one fits every code. */
  mask: number;
  name: string;
  text: Words;
  /** For engineers. */
  detail: Words;
}

export const emergencies: readonly EmergencyInfo[] = [
)";
  for (const auto& e : kEmergencies) {
    out += "  {\n    code: " + hex_text(e.code, 4) + ", mask: " + hex_text(e.mask, 4) + ", name: " + quoted(e.name) +
           ",\n    text: " + words(e.text_en, e.text_de) + ",\n    detail: " + words(e.detail_en, e.detail_de) + ",\n  },\n";
  }
  return {"web/src/contract/emergencies.gen.ts", out + "];\n"};
}

std::string_view yes_or_no(bool value) { return value ? "true" : "false"; }

std::string exercise_sizes(const ExerciseInfo& exercise) {
  std::string out;
  for (const ExerciseSize& row : kExerciseSizes) {
    if (row.shape != exercise.shape) continue;
    out += "\n      { name: " + quoted(row.name) + ", title: " + words(row.title_en, row.title_de) +
           ", required: " + std::string(yes_or_no(row.required)) + ", usual_m: " + number_text(row.usual_m) +
           ", driven_least_m: " + number_text(row.driven_least_m) + ", driven_most_m: " + number_text(row.driven_most_m) +
           ", share: " + number_text(row.share) + " },";
  }
  return out;
}

std::string usual_own_line() {
  const Exercise usual = usual_exercise(ExerciseShape::own);
  std::string x_m, y_m;
  for (std::size_t i = 0; i < usual.line.count; ++i) {
    x_m += (i == 0 ? "" : ", ") + number_text(usual.line.points[i].x_m);
    y_m += (i == 0 ? "" : ", ") + number_text(usual.line.points[i].y_m);
  }
  return "{ shape: 'own', closed: " + std::string(yes_or_no(usual.line.closed)) + ", x_m: [" + x_m + "], y_m: [" + y_m +
         "], corner_radius_m: " + number_text(usual.radius_m) + " }";
}

GeneratedFile exports_file() {
  std::string out = head("db/export/formats.def");
  out += "import type { Words } from './rest.gen';\n\n";
  out += name_union("ExportFormat", db::kExportFormats);
  out += R"(
export interface ExportFormatInfo {
  name: ExportFormat;
  title: Words;
  /** Whether live values can be chosen with `columns`. */
  columns: boolean;
}

export const exportFormats: readonly ExportFormatInfo[] = [
)";
  for (const db::ExportFormatInfo& format : db::kExportFormats)
    out += "  { name: " + quoted(format.name) + ", title: " + words(format.title_en, format.title_de) +
           ", columns: " + (format.columns == db::ExportColumns::chosen ? "true" : "false") + " },\n";
  return {"web/src/contract/exports.gen.ts", out + "];\n"};
}

GeneratedFile metrics_file() {
  std::string out = head("db/metrics/metric_list.hpp");
  out += "import type { Words } from './rest.gen';\n\n";
  out += "export type MetricKey =";
  for (const db::MetricInfo& metric : db::kMetrics) out += "\n  | " + quoted(metric.key);
  out += R"(;

export interface MetricInfo {
  key: MetricKey;
  group: MetricGroup;
  title: Words;
  /** On screens: value times factor, so many digits, then the unit. */
  unit: string;
  factor: number;
  digits: number;
}

export type MetricGroup = )";
  for (const db::MetricGroupInfo& group : db::kMetricGroups) out += (&group == db::kMetricGroups.data() ? "" : " | ") + quoted(group.name);
  out += ";\n\nexport const metricGroups: readonly { name: MetricGroup; title: Words }[] = [\n";
  for (const db::MetricGroupInfo& group : db::kMetricGroups)
    out += "  { name: " + quoted(group.name) + ", title: " + words(group.title_en, group.title_de) + " },\n";
  out += "];\n\nexport const metrics: readonly MetricInfo[] = [\n";
  for (const db::MetricInfo& metric : db::kMetrics)
    out += "  {\n    key: " + quoted(metric.key) + ", group: " + quoted(db::kMetricGroups[static_cast<std::size_t>(metric.group)].name) +
           ", title: " + words(metric.title_en, metric.title_de) + ",\n    unit: " + quoted(metric.screen_unit) +
           ", factor: " + number_text(db::screen_factor(metric)) + ", digits: " + std::to_string(metric.digits) + ",\n  },\n";
  return {"web/src/contract/metrics.gen.ts", out + "];\n"};
}

GeneratedFile exercises_file() {
  std::string out = head("control/contract/exercises.def");
  out += R"(import type { Exercise, Words } from './rest.gen';

export interface ExerciseSizeInfo {
  name: string;
  title: Words;
  required: boolean;
  /** 0 = left out. */
  usual_m: number;
  /** Range that the hoist drives by itself. */
  driven_least_m: number;
  driven_most_m: number;
  /** At most this share of the shape's first size; 0 = no such limit. */
  share: number;
}
export interface ExerciseInfo {
  shape: Exercise['shape'];
  title: Words;
  /** May be walked clockwise too. */
  turned: boolean;
  /** May have laps. */
  closed: boolean;
  /** One lap of the usual sizes, to a millimetre. */
  usual_length_m: number;
  sizes: readonly ExerciseSizeInfo[];
}

export const exercises: readonly ExerciseInfo[] = [
)";
  std::string usual;
  for (const ExerciseInfo& row : kExercises) {
    out += "  {\n    shape: " + quoted(row.name) + ", title: " + words(row.title_en, row.title_de) +
           ", turned: " + std::string(yes_or_no(row.turned)) + ", closed: " + std::string(yes_or_no(row.closed)) +
           ", usual_length_m: " + number_text(std::round(figure_of(usual_exercise(row.shape)).length_m() * 1000.0) / 1000.0) +
           ",\n    sizes: [" + exercise_sizes(row) + "],\n  },\n";
    if (row.shape == ExerciseShape::own) continue;
    usual += "  " + std::string(row.name) + ": { shape: " + quoted(row.name);
    for (const ExerciseSize& size : kExerciseSizes)
      if (size.shape == row.shape && size.usual_m > 0) usual += ", " + std::string(size.name) + ": " + number_text(size.usual_m);
    usual += " },\n";
  }
  out += "];\n\n/** Each shape with its usual sizes. */\nexport const usualExercise = {\n" + usual +
         "} as const satisfies { [S in Exclude<Exercise['shape'], 'own'>]: Extract<Exercise, { shape: S }> };\n\n/** An own line for "
         "examples. */\n" +
         "export const usualOwnLine: Extract<Exercise, { shape: 'own' }> = " + usual_own_line() + ";\n";
  return {"web/src/contract/exercises.gen.ts", out};
}

}  // namespace

std::vector<GeneratedFile> typescript_files() {
  return {params_file(),      signals_file(),   topics_file(),  faults_file(),
          emergencies_file(), exercises_file(), exports_file(), metrics_file()};
}

}  // namespace hoist::gen
