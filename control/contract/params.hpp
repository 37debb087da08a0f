// Typed view of params.def: the struct the tick uses, the description of every row, the one place that checks a value.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/check.hpp"

namespace hoist::contract {

enum class EditRule : std::uint8_t { live, stopped };
enum class ParamScope : std::uint8_t { core, drive, tilt };
enum class Role : std::uint8_t { viewer, therapist, engineer };

// All parameters in SI units, at their defaults until set.
struct Params {
#define HOIST_PARAM(id, name, unit, lo, def, hi, edit, scope, role, source, ...) double name = static_cast<double>(def);
#define HOIST_PARAM_RETIRED(id)
#define HOIST_PARAM_OBJECT(...)
#define HOIST_PRESET(...)
#define HOIST_PRESET_VALUE(...)
#include "control/contract/params.def"
#undef HOIST_PARAM
};

struct ParamInfo {
  std::uint16_t id;
  std::string_view name;
  std::string_view unit;
  double min;
  double default_value;
  double max;
  EditRule edit;
  ParamScope scope;
  Role role;
  std::string_view source;
  std::string_view title_en, effect_en, title_de, effect_de;
  double Params::*field;
};

inline constexpr std::array kParams{
#define HOIST_PARAM(id, name, unit, lo, def, hi, edit, scope, role, source, title_en, effect_en, title_de, effect_de) \
  ParamInfo{id,                                                                                                       \
            #name,                                                                                                    \
            unit,                                                                                                     \
            static_cast<double>(lo),                                                                                  \
            static_cast<double>(def),                                                                                 \
            static_cast<double>(hi),                                                                                  \
            EditRule::edit,                                                                                           \
            ParamScope::scope,                                                                                        \
            Role::role,                                                                                               \
            source,                                                                                                   \
            title_en,                                                                                                 \
            effect_en,                                                                                                \
            title_de,                                                                                                 \
            effect_de,                                                                                                \
            &Params::name},
#include "control/contract/params.def"
#undef HOIST_PARAM
};
inline constexpr std::size_t kParamCount = kParams.size();

// Index of a parameter in kParams, by name at compile time: param_index(ParamName::lean_gain_filtered_units).
enum class ParamName : std::uint16_t {
#define HOIST_PARAM(id, name, ...) name,
#include "control/contract/params.def"
#undef HOIST_PARAM
};
constexpr std::size_t param_index(ParamName name) { return static_cast<std::size_t>(name); }

constexpr std::optional<std::size_t> find_param(std::string_view name) {
  for (std::size_t i = 0; i < kParamCount; ++i)
    if (kParams[i].name == name) return i;
  return std::nullopt;
}
constexpr std::optional<std::size_t> find_param_id(std::uint32_t id) {
  for (std::size_t i = 0; i < kParamCount; ++i)
    if (kParams[i].id == id) return i;
  return std::nullopt;
}

constexpr double get_param(const Params& params, std::size_t index) { return params.*(kParams[index].field); }
constexpr void set_param_unchecked(Params& params, std::size_t index, double value) { params.*(kParams[index].field) = value; }

enum class ParamCheck : std::uint8_t { ok, unknown, not_finite, out_of_range };
// Whether a value may be stored in this row. NaN and infinities are never in range.
inline ParamCheck check_param(std::size_t index, double value) {
  if (index >= kParamCount) return ParamCheck::unknown;
  if (!std::isfinite(value)) return ParamCheck::not_finite;
  return value < kParams[index].min || value > kParams[index].max ? ParamCheck::out_of_range : ParamCheck::ok;
}

// THE cross checks: values that are each in range and still contradict each other. The first must be below the second,
// or at most as large.
struct ParamOrder {
  ParamName smaller, larger;
  bool may_be_equal;
  const char* sentence;
};
inline constexpr std::array kParamOrders{
    ParamOrder{ParamName::remote_slow_age_s, ParamName::remote_stop_age_s, false, "remote_slow_age_s must be below remote_stop_age_s"},
    ParamOrder{ParamName::fall_tilt_rad, ParamName::fall_static_tilt_rad, false, "fall_tilt_rad must be below fall_static_tilt_rad"},
    ParamOrder{ParamName::battery_empty_v, ParamName::battery_low_v, false, "battery_empty_v must be below battery_low_v"},
    ParamOrder{ParamName::base_tilt_slow_rad, ParamName::base_tilt_stop_rad, false, "base_tilt_slow_rad must be below base_tilt_stop_rad"},
    ParamOrder{ParamName::remote_speed_m_s_max, ParamName::speed_m_s_max, true, "remote_speed_m_s_max must not exceed speed_m_s_max"},
    ParamOrder{ParamName::remote_yaw_rate_rad_s_max, ParamName::yaw_rate_rad_s_max, true,
               "remote_yaw_rate_rad_s_max must not exceed yaw_rate_rad_s_max"},
    ParamOrder{ParamName::acceleration_m_s2_max, ParamName::protective_deceleration_m_s2, true,
               "protective_deceleration_m_s2 must not be below acceleration_m_s2_max"},
    ParamOrder{ParamName::protective_deceleration_m_s2, ParamName::bumper_deceleration_m_s2, true,
               "bumper_deceleration_m_s2 must not be below protective_deceleration_m_s2"},
};
/// Full lean must stay below a lean that counts as hanging or as a fall by itself (H15, H16, H27). The quick fall is not among them: it needs
/// a rate besides. Checked when one of the two is changed, not when a stored set is loaded: a machine that kept older values goes on with
/// them, and with its calibration.
struct ParamRoom {
  ParamName smaller, larger;
  double room;
};
/// One degree.
inline constexpr double kLeanRoom_rad = 0.0174;
inline constexpr std::array kParamRooms{
    ParamRoom{ParamName::lean_range_rad, ParamName::hang_tilt_rad, kLeanRoom_rad},
    ParamRoom{ParamName::lean_range_rad, ParamName::fall_static_tilt_rad, kLeanRoom_rad},
};
/// Written so that NaN leaves no room.
constexpr bool leaves_room(const ParamRoom& row, const Params& p) {
  return get_param(p, param_index(row.smaller)) + row.room <= get_param(p, param_index(row.larger));
}
/// Motor turns per wheel turn. params.def gives the encoder as 60000 counts per wheel turn = 2000 at the motor through gear 30; the
/// drive's objects 60FFh and 606Ch speak at the motor.
inline constexpr double kGearRatio_norm = 30.0;
inline double smaller_wheel_scale_norm(const Params& p) {
  return p.wheel_left_scale_norm < p.wheel_right_scale_norm ? p.wheel_left_scale_norm : p.wheel_right_scale_norm;
}
/// H27: the drives follow their command on a ramp of their own (6083h). A ramp slower than the hardest stop would
/// lengthen every stop without an alarm. The bumper's stop is compared with a margin of 10 %, because a wheel's radius
/// is measured and both values are equal by default. The protective stop, whose distance is shown, needs room above it
/// (measured: the shown distance was never exceeded from 1.17 on).
inline constexpr double kRampOfBumper_norm = 0.9, kRampOfProtective_norm = 1.2;
inline bool ramp_fits_stops(const Params& p) {
  const double ramp_m_s2 = p.drive_acceleration_rad_s2 * p.wheel_radius_m * smaller_wheel_scale_norm(p) / kGearRatio_norm;
  return ramp_m_s2 >= kRampOfBumper_norm * p.bumper_deceleration_m_s2 &&
         ramp_m_s2 >= kRampOfProtective_norm * p.protective_deceleration_m_s2;
}
// nullptr = consistent; otherwise the sentence for people. Written so that NaN is never consistent.
inline const char* check_param_set(const Params& p) {
  for (const ParamOrder& order : kParamOrders) {
    const double smaller = get_param(p, param_index(order.smaller)), larger = get_param(p, param_index(order.larger));
    if (!(order.may_be_equal ? smaller <= larger : smaller < larger)) return order.sentence;
  }
  if (!ramp_fits_stops(p))
    return "drive_acceleration_rad_s2 is too slow at the wheel for bumper_deceleration_m_s2 or protective_deceleration_m_s2";
  return nullptr;
}

// Parameters that live in nodes: where.
enum class NodeKind : std::uint8_t { tilt, drive, io, host };
struct ParamObject {
  ParamName param;
  NodeKind kind;
  std::uint16_t index;
  std::uint8_t sub;
};
inline constexpr std::array kParamObjects{
#undef HOIST_PARAM_OBJECT
#define HOIST_PARAM(...)
#define HOIST_PARAM_OBJECT(name, kind, index, sub) ParamObject{ParamName::name, NodeKind::kind, index, sub},
#include "control/contract/params.def"
#undef HOIST_PARAM_OBJECT
#define HOIST_PARAM_OBJECT(...)
};

struct PresetInfo {
  std::string_view name, title_en, title_de, doc_en, doc_de;
};
inline constexpr std::array kPresets{
#undef HOIST_PRESET
#define HOIST_PRESET(name, title_en, title_de, doc_en, doc_de) PresetInfo{#name, title_en, title_de, doc_en, doc_de},
#include "control/contract/params.def"
#undef HOIST_PRESET
#define HOIST_PRESET(...)
};
struct PresetValue {
  std::string_view preset;
  ParamName param;
  double value;
};
inline constexpr std::array kPresetValues{
#undef HOIST_PRESET_VALUE
#define HOIST_PRESET_VALUE(preset, name, value) PresetValue{#preset, ParamName::name, static_cast<double>(value)},
#include "control/contract/params.def"
#undef HOIST_PRESET_VALUE
};
#undef HOIST_PARAM
#undef HOIST_PARAM_RETIRED
#undef HOIST_PARAM_OBJECT
#undef HOIST_PRESET

static_assert(unique_by(kParams, [](const ParamInfo& p) { return p.id; }), "params.def: an id is used twice");
static_assert(unique_by(kParams, [](const ParamInfo& p) { return p.name; }), "params.def: a name is used twice");
static_assert(all_rows(kParams, [](const ParamInfo& p) { return p.min <= p.default_value && p.default_value <= p.max && p.min < p.max; }),
              "params.def: a default lies outside its range");
static_assert(all_rows(kParams,
                       [](const ParamInfo& p) {
                         return !p.source.empty() && !p.title_en.empty() && !p.effect_en.empty() && !p.title_de.empty() &&
                                !p.effect_de.empty();
                       }),
              "params.def: a row lacks its source or its words");
static_assert(all_rows(kPresetValues,
                       [](const PresetValue& v) {
                         const ParamInfo& p = kParams[param_index(v.param)];
                         return v.value >= p.min && v.value <= p.max;
                       }),
              "params.def: a preset value lies outside its range");
static_assert(all_rows(kParams,
                       [](const ParamInfo& p) {
                         if (p.scope == ParamScope::core) return true;
                         for (const ParamObject& o : kParamObjects)
                           if (kParams[param_index(o.param)].name == p.name) return true;
                         return false;
                       }),
              "params.def: a node parameter has no object");

constexpr std::uint64_t params_hash() {
  std::uint64_t hash = kHashStart;
  for (const ParamInfo& p : kParams) hash = hash_number(hash_bytes(hash_bytes(hash, p.name), p.unit), p.id);
  return hash;
}

}  // namespace hoist::contract
