// One CANopen node: the common part of tilt sensor, drive and input board. CiA 301, the services named in README.md.
//
// The application passes itself to on_frame() and tick_1ms() and is called back:
//   void on_sync()                       a SYNC came while operational; the synchronous PDOs are packed right after it
//   void on_rpdo()                       RPDO1 was accepted and its objects are stored
//   void on_rpdo_deadline()              RPDO1 has timed out
//   void on_heartbeat_lost()             the computer's heartbeat has timed out, or the computer has restarted
//   void on_nmt(from, to)                the state of the node has changed
//   void on_power_on()                   reset: forget everything
//   SdoAbort check_write(index, sub, raw)   final check of a write that type, access and range allow
// An application without RPDO or heartbeat consumer has empty callbacks.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "control/contract/can_dictionary.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/object_table.hpp"
#include "firmware/lib/parameter_store.hpp"
#include "firmware/lib/program_control.hpp"
#include "firmware/lib/sdo_server.hpp"
#include "firmware/lib/version.hpp"

namespace hoist::firmware {

using contract::canopen::NmtCommand;
using contract::canopen::NmtState;

// Emergency codes in use (CiA 301 and 402).
namespace emcy {
inline constexpr std::uint16_t kNone = 0x0000, kOverCurrent = 0x2310, kUnderVoltage = 0x3220, kHardware = 0x5000, kParametersLost = 0x6310,
                               kEncoder = 0x7305, kCanOverrun = 0x8110, kCanPassive = 0x8120, kHeartbeat = 0x8130,
                               kBusOffRecovered = 0x8140, kPdoTooShort = 0x8210, kPdoTooLong = 0x8220, kRpdoDeadline = 0x8250,
                               kOverSpeed = 0x8400;
}
// Bits of the error register 1001h. Bit 0 is set while any error is.
namespace error_bit {
inline constexpr std::uint8_t kGeneric = 0x01, kCurrent = 0x02, kVoltage = 0x04, kCommunication = 0x10, kProfile = 0x20;
}

inline constexpr std::size_t kErrorsMax = 8;     // different errors active at the same time
inline constexpr std::size_t kEmcyQueueMax = 8;  // EMCY waiting for the inhibit time; later ones are counted and dropped
inline constexpr std::size_t kErrorHistory = 4;  // errors that 1003h remembers
inline constexpr std::uint32_t kConsumerMin_ms = 100, kConsumerMax_ms = 500;  // allowed consumer heartbeat times
inline constexpr std::uint32_t kOverrunHold_ms = 1000;                        // lost frames are an error until none was lost for so long
inline constexpr std::uint32_t kBusOffWait_ms = 200;                          // before each restart of a bus-off controller
inline constexpr std::uint32_t kHeartbeatMin_ms = 10;                         // faster ones would take the bus; 0 is off (CiA 301)

// Where the RPDO of a kind is in its kPdoRows. Outside of the node, because a class is not complete inside its own constants (clang).
template <contract::NodeKind kKind>
consteval std::size_t find_rpdo() {
  for (std::size_t i = 0; i < kPdoRows<kKind>.size(); ++i)
    if (kPdoRows<kKind>[i].direction == contract::PdoDirection::rx) return i;
  return kNoObject;
}

// Device names 1008h.
constexpr std::string_view device_name(contract::NodeKind kind) {
  switch (kind) {
    case contract::NodeKind::tilt:
      return "Hoist tilt sensor";
    case contract::NodeKind::drive:
      return "Hoist drive";
    default:
      return "Hoist input board";
  }
}

struct NodeCounters {
  std::uint32_t wrong_length = 0;  // frames for this node with a DLC that the service does not have
  std::uint32_t out_of_range = 0;  // RPDOs refused because of a value
  std::uint32_t unknown = 0;       // NMT commands or SDO requests that do not exist
  std::uint32_t tx_refused = 0;    // process data that the controller had no room for
  std::uint32_t emcy_lost = 0;
  std::uint32_t sdo_aborts = 0;
};

// A board with a hardware name has `static constexpr std::string_view kHardwareName`; others use a default. A board with a serial number
// has `std::uint32_t serial_number() const`.
template <StoringBoard Board, contract::NodeKind kKind>
class CanopenNode {
 public:
  static_assert(kKind != contract::NodeKind::host);
  static constexpr auto& kRows = kObjectRows<kKind>;
  static constexpr auto& kPdos = kPdoRows<kKind>;

  CanopenNode(Board& board, contract::Node node)
      : board_(board), node_id_(contract::node_id(node)), node_(node), sdo_(contract::node_id(node)) {
    power_on();
  }

  void power_on() {
    state_ = NmtState::boot_up;
    counters_ = {};
    sdo_ = SdoServer(node_id_);
    errors_ = {};
    error_count_ = 0;
    overrun_age_ms_ = kOverrunHold_ms;
    can_lost_ = board_.can_health().lost;
    bus_off_ = false;
    leave_communication();
    restore(0, 0xFFFF);
    if (!parameters_ok_) set_error(emcy::kParametersLost, error_bit::kProfile, true);
  }

  template <class App>
  void on_frame(const CanFrame& frame, App& app) {
    if ((frame.flags & (CanFrame::kExtended | CanFrame::kRemote | CanFrame::kError)) != 0) return;  // nothing of ours
    if (state_ == NmtState::boot_up) return;  // still starting: the boot-up message has not left yet
    if (frame.id == contract::canopen::kNmt) return on_nmt_command(frame, app);
    if (frame.id == contract::canopen::kSync) return on_sync(frame, app);
    if (frame.id == contract::canopen::kSdoRequestBase + node_id_) return on_sdo(frame, app);
    if constexpr (kHasHeartbeatConsumer)
      if (frame.id == contract::canopen::kHeartbeatBase + watched_node()) return on_heartbeat(frame, app);
    if constexpr (kHasRpdo)
      if (frame.id == (values_.raw(kPdos[kRpdoAt].communication) & ~contract::kPdoNoRemoteBit)) return on_rpdo(frame, app);
  }

  template <class App>
  void tick_1ms(App& app) {
    watch_controller(app);
    if (state_ == NmtState::boot_up) {
      if (!board_.send(contract::canopen::heartbeat(node_id_, NmtState::boot_up))) return;
      heartbeat_age_ms_ = 0;
      change_state(NmtState::pre_operational, app);
      return;
    }
    send_heartbeat();
    if constexpr (requires { board_.restart(true); })
      if (restart_in_ms_ != 0 && --restart_in_ms_ == 0) return board_.restart(true);
    Dictionary<App> dictionary{*this, app};
    sdo_.tick_1ms(dictionary);
    send_sdo_answer();
    watch_heartbeat(app);
    watch_rpdo(app);
    send_timed_pdos();
    send_emergencies();
  }

  [[nodiscard]] NmtState state() const { return state_; }
  [[nodiscard]] bool operational() const { return state_ == NmtState::operational; }
  [[nodiscard]] std::uint8_t node_id() const { return node_id_; }
  [[nodiscard]] contract::Node node() const { return node_; }
  [[nodiscard]] NodeCounters counters() const {
    NodeCounters all = counters_;
    all.wrong_length += sdo_.wrong_lengths();
    all.unknown += sdo_.unknown();
    all.sdo_aborts = sdo_.aborts();
    return all;
  }
  [[nodiscard]] ObjectValues<kKind>& values() { return values_; }
  [[nodiscard]] const ObjectValues<kKind>& values() const { return values_; }
  // RPDO1 has come within its deadline.
  [[nodiscard]] bool rpdo_alive() const { return rpdo_armed_; }

  // Whether the stored parameters could be read, or none were ever stored. False: the node runs on defaults although parameters had been
  // saved; EMCY 6310h until parameters are saved again or defaults are restored.
  [[nodiscard]] bool parameters_ok() const { return parameters_ok_; }

  // A PDO sent on events goes out as soon as its inhibit time allows, an acyclic one (type 0) with the next SYNC.
  void request_pdo(contract::Pdo pdo) {
    for (std::size_t i = 0; i < kPdos.size(); ++i)
      if (kPdos[i].pdo == pdo) pdo_requested_[i] = true;
  }

  // How many frames of this PDO have left since power-on; wraps.
  [[nodiscard]] std::uint32_t sent(contract::Pdo pdo) const {
    for (std::size_t i = 0; i < kPdos.size(); ++i)
      if (kPdos[i].pdo == pdo) return pdo_sent_[i];
    return 0;
  }

  // Sets or clears an error: keeps 1001h, and sends one EMCY for each change.
  void set_error(std::uint16_t code, std::uint8_t register_bit, bool active) {
    std::size_t at = 0;
    while (at < error_count_ && errors_[at].code != code) ++at;
    if ((at < error_count_) == active) return;
    if (active) {
      if (error_count_ == kErrorsMax) {
        ++counters_.emcy_lost;
        return;
      }
      errors_[error_count_++] = Error{code, register_bit};
    } else {
      errors_[at] = errors_[--error_count_];
    }
    std::uint8_t error_register = error_count_ == 0 ? 0 : error_bit::kGeneric;
    for (std::size_t i = 0; i < error_count_; ++i) error_register = static_cast<std::uint8_t>(error_register | errors_[i].register_bit);
    values_.template set<0x1001>(error_register);
    report(active ? code : emcy::kNone);
  }

 private:
  struct Error {
    std::uint16_t code = 0;
    std::uint8_t register_bit = 0;
  };
  struct Emergency {
    std::uint16_t code = 0;
    std::uint8_t error_register = 0;
  };

  static constexpr std::size_t kRpdoAt = find_rpdo<kKind>();
  static constexpr bool kHasRpdo = kRpdoAt != kNoObject;
  static constexpr bool kHasHeartbeatConsumer = find_row<kKind>(0x1016, 1) != kNoObject;

  static constexpr std::size_t kHistoryAt = find_row<kKind>(0x1003, 1);
  static_assert(find_row<kKind>(0x1003, kErrorHistory) == kHistoryAt + kErrorHistory - 1 &&
                find_row<kKind>(0x1003, kErrorHistory + 1) == kNoObject);
  using Store = ParameterStore<std::remove_cvref_t<decltype(std::declval<Board&>().flash())>>;
  static constexpr std::uint16_t kPlaceRecord = 0x0001;  // first record of a copy: the node id that saved it; no object has this index
  static_assert(store_bytes(kStoredRows<kKind>.size() + 1) <= std::remove_cvref_t<decltype(std::declval<Board&>().flash())>::kPageBytes);

  // One EMCY, and its line in 1003h when it is an error rather than the end of one.
  void report(std::uint16_t code) {
    const std::uint8_t error_register = values_.template get<0x1001>();
    if (code != emcy::kNone) {
      for (std::size_t i = kErrorHistory - 1; i > 0; --i) values_.set_raw(kHistoryAt + i, values_.raw(kHistoryAt + i - 1));
      values_.set_raw(kHistoryAt, code | (static_cast<std::uint32_t>(error_register) << 16));
      const std::uint8_t count = values_.template get<0x1003>();
      if (count < kErrorHistory) values_.template set<0x1003>(static_cast<std::uint8_t>(count + 1U));
    }
    if (emcy_count_ == kEmcyQueueMax) {
      ++counters_.emcy_lost;
      return;
    }
    emcy_[(emcy_first_ + emcy_count_++) % kEmcyQueueMax] = Emergency{code, error_register};
  }

  [[nodiscard]] Store store() { return Store(board_.flash(), static_cast<std::uint8_t>(kKind)); }

  // Values at power-on of the objects in a range of indices: defaults, values that depend on the node, then stored parameters.
  void restore(std::uint16_t first, std::uint16_t last) {
    values_.restore(first, last);
    identify();
    parameters_ok_ = true;
    bool ours = true;
    const StoreState state = store().load([&](const StoredValue& value) {
      if (value.index == kPlaceRecord) ours = value.raw == node_id_;
      if (!ours || value.index == kPlaceRecord) return;
      const std::size_t at = find_row<kKind>(value.index, value.sub);
      if (at == kNoObject || !kRows[at].stored) return;  // of an older or newer program
      const bool fits = contract::object_bytes(kRows[at].type) == value.bytes && in_range(kRows[at], value.raw);
      if (!fits)
        parameters_ok_ = false;  // this one has its default; said again at every reset, whichever range that restores
      else if (value.index >= first && value.index <= last && !(value.index == 0x1017 && value.raw == 0))
        values_.set_raw(at, value.raw);  // a heartbeat can be off only until the next start: the core could not find the node
    });
    // Saved at another place on the hoist: identifiers and mounting are that place's.
    if (state == StoreState::lost || !ours) parameters_ok_ = false;
  }

  // The objects whose value depends on the node rather than on the table.
  void identify() {
    for (std::size_t i = 0; i < kRows.size(); ++i)
      if (contract::is_node_relative(kRows[i].index, kRows[i].sub)) values_.set_raw(i, kRows[i].initial + node_id_);
    for (const PdoRow& row : kPdos)
      if (!contract::pdo_on_by_default(row.pdo, node_))
        values_.set_raw(row.communication, values_.raw(row.communication) | contract::kPdoOffBit);
    values_.template set<0x1000>(contract::device_type(kKind));
    values_.template set<0x1018, 2>(contract::product_code(kKind) | (board_.simulated() ? contract::canopen::kSimulatedProduct : 0U));
    if constexpr (requires { board_.serial_number(); }) values_.template set<0x1018, 4>(board_.serial_number());
    if constexpr (LoadableBoard<Board>) {
      values_.template set<contract::kProgramId, 1>(board_.program().crc);
      values_.template set<contract::kProgramVersion, 1>(board_.program().version);
    }
  }

  // Everything that must not survive a reset of the communication.
  void leave_communication() {
    heartbeat_age_ms_ = 0;
    watched_armed_ = false;
    rpdo_armed_ = false;
    sdo_.forget();
    restart_in_ms_ = 0;
    emcy_count_ = 0;
    emcy_age_ms_ = 0xFFFF;
    pdo_syncs_ = {};
    pdo_age_ms_ = {};
    pdo_requested_ = {};
  }

  template <class App>
  void change_state(NmtState to, App& app) {
    if (state_ == to) return;
    const NmtState from = state_;
    state_ = to;
    if (to == NmtState::stopped) sdo_.forget();  // a stopped node has no SDO, not even to end a transfer
    restart_in_ms_ = 0;                          // the state changed meanwhile: the previous check no longer holds
    if (to == NmtState::operational) {
      pdo_syncs_ = {};
      pdo_age_ms_ = {};
      pdo_requested_ = {};
    }
    rpdo_armed_ = false;
    app.on_nmt(from, to);
  }

  template <class App>
  void on_nmt_command(const CanFrame& frame, App& app) {
    if (frame.dlc != 2) {
      ++counters_.wrong_length;
      return;
    }
    if (frame.data[1] != 0 && frame.data[1] != node_id_) return;
    switch (static_cast<NmtCommand>(frame.data[0])) {
      case NmtCommand::start:
        return change_state(NmtState::operational, app);
      case NmtCommand::stop:
        return change_state(NmtState::stopped, app);
      case NmtCommand::pre_operational:
        return change_state(NmtState::pre_operational, app);
      case NmtCommand::reset_node:
        power_on();
        app.on_power_on();
        return;
      case NmtCommand::reset_communication:
        leave_communication();
        errors_ = {};
        error_count_ = 0;
        restore(0x1000, 0x1FFF);
        if (!parameters_ok_) set_error(emcy::kParametersLost, error_bit::kProfile, true);
        change_state(NmtState::boot_up, app);
        return;
      default:
        ++counters_.unknown;
    }
  }

  template <class App>
  void on_sync(const CanFrame& frame, App& app) {
    if (frame.dlc != 0) {  // 1019h does not exist here, so a SYNC has no counter
      ++counters_.wrong_length;
      return;
    }
    if (!operational()) return;
    app.on_sync();
    for (std::size_t i = 0; i < kPdos.size(); ++i) {
      const PdoRow& row = kPdos[i];
      const std::uint32_t type = pdo_type(row);
      if (row.direction != contract::PdoDirection::tx || type > kLastSyncType) continue;
      if (type == 0 ? !pdo_requested_[i] : ++pdo_syncs_[i] < type) continue;
      pdo_syncs_[i] = 0;
      pdo_requested_[i] = false;
      (void)send_pdo(i);  // no room: counted; the next SYNC brings newer values
    }
  }

  [[nodiscard]] bool send_pdo(std::size_t which) {
    const PdoRow& row = kPdos[which];
    const std::uint32_t id = values_.raw(row.communication);
    if ((id & contract::kPdoOffBit) != 0) return true;
    CanFrame frame{id & ~contract::kPdoNoRemoteBit, row.bytes, 0, {}};
    std::size_t at = 0;
    for (std::size_t i = 0; i < row.entries; ++i) {
      const std::size_t bytes = contract::object_bytes(kRows[row.row[i]].type);
      contract::write_le(&frame.data[at], bytes, values_.raw(row.row[i]));
      at += bytes;
    }
    if (board_.send(frame)) {
      ++pdo_sent_[which];
      return true;
    }
    ++counters_.tx_refused;
    return false;
  }

  static constexpr std::uint32_t kLastSyncType = 240;
  [[nodiscard]] std::uint32_t pdo_type(const PdoRow& row) const { return values_.raw(row.communication + 1U); }

  // Types 254 and 255: on request, at most once per inhibit time, and in any case once per event timer (0 = only on request).
  void send_timed_pdos() {
    if (!operational()) return;
    for (std::size_t i = 0; i < kPdos.size(); ++i) {
      const PdoRow& row = kPdos[i];
      if (row.direction != contract::PdoDirection::tx || pdo_type(row) <= kLastSyncType) continue;
      if (pdo_age_ms_[i] < 0xFFFF) ++pdo_age_ms_[i];
      const std::uint32_t inhibit_ms = (values_.raw(row.communication + 2U) + 9U) / 10U, event_ms = values_.raw(row.communication + 3U);
      const bool due = (event_ms != 0 && pdo_age_ms_[i] >= event_ms) || (pdo_requested_[i] && pdo_age_ms_[i] >= inhibit_ms);
      if (!due || !send_pdo(i)) continue;  // no room: tried again in the next tick
      pdo_age_ms_[i] = 0;
      pdo_requested_[i] = false;
    }
  }

  void send_heartbeat() {
    const std::uint16_t period_ms = values_.template get<0x1017>();
    if (heartbeat_age_ms_ < 0xFFFF) ++heartbeat_age_ms_;
    if (period_ms != 0 && heartbeat_age_ms_ >= period_ms && board_.send(contract::canopen::heartbeat(node_id_, state_)))
      heartbeat_age_ms_ = 0;
  }

  void send_emergencies() {
    const std::uint16_t inhibit_ms = static_cast<std::uint16_t>(values_.template get<0x1015>() / 10U);
    if (emcy_age_ms_ < 0xFFFF) ++emcy_age_ms_;
    if (emcy_count_ == 0 || emcy_age_ms_ < inhibit_ms || state_ == NmtState::stopped) return;
    const Emergency& next = emcy_[emcy_first_];
    CanFrame frame{contract::canopen::kEmcyBase + node_id_, 8, 0, {}};
    contract::write_le(&frame.data[0], 2, next.code);
    frame.data[2] = next.error_register;
    if (!board_.send(frame)) return;
    emcy_first_ = (emcy_first_ + 1) % kEmcyQueueMax;
    --emcy_count_;
    emcy_age_ms_ = 0;
  }

  // 1016h:1 = node << 16 | milliseconds.
  [[nodiscard]] std::uint32_t watched_node() const { return (values_.template get<0x1016, 1>() >> 16) & 0x7FU; }

  template <class App>
  void on_heartbeat(const CanFrame& frame, App& app) {
    if (frame.dlc != 1) {
      ++counters_.wrong_length;
      return;
    }
    // A boot-up message of a running node means that it has restarted and lost its state.
    if (frame.data[0] == static_cast<std::uint8_t>(NmtState::boot_up)) {
      if (watched_armed_) lose_heartbeat(app);
      return;
    }
    watched_armed_ = true;
    watched_age_ms_ = 0;
    set_error(emcy::kHeartbeat, error_bit::kCommunication, false);
  }
  template <class App>
  void watch_heartbeat(App& app) {
    if constexpr (kHasHeartbeatConsumer) {
      if (!watched_armed_) return;
      if (++watched_age_ms_ >= (values_.template get<0x1016, 1>() & 0xFFFFU)) lose_heartbeat(app);
    }
  }
  template <class App>
  void lose_heartbeat(App& app) {
    watched_armed_ = false;  // watches again from the next heartbeat on
    set_error(emcy::kHeartbeat, error_bit::kCommunication, true);
    app.on_heartbeat_lost();
    apply_error_behaviour(app);
  }

  // 1029h:1: what a communication error does to the state of the node.
  template <class App>
  void apply_error_behaviour(App& app) {
    switch (values_.template get<0x1029, 1>()) {
      case 0:
        if (operational()) change_state(NmtState::pre_operational, app);
        break;
      case 2:
        change_state(NmtState::stopped, app);
        break;
      default:
        break;
    }
  }

  // The controller's own health. A bus-off controller neither receives nor sends: the node leaves operation, and its master starts it again
  // like any lost node.
  template <class App>
  void watch_controller(App& app) {
    const CanHealth health = board_.can_health();
    values_.template set<0x2300, 1>(static_cast<std::uint8_t>(health.state));
    values_.template set<0x2300, 2>(health.tx_errors);
    values_.template set<0x2300, 3>(health.rx_errors);
    values_.template set<0x2300, 4>(health.lost);
    if (health.lost != can_lost_) overrun_age_ms_ = 0;
    can_lost_ = health.lost;
    if (overrun_age_ms_ < kOverrunHold_ms) ++overrun_age_ms_;
    set_error(emcy::kCanOverrun, error_bit::kCommunication, overrun_age_ms_ < kOverrunHold_ms);
    set_error(emcy::kCanPassive, error_bit::kCommunication, health.state >= CanHealth::State::passive);
    const bool was_off = bus_off_;
    bus_off_ = health.state == CanHealth::State::bus_off;
    if (bus_off_ && !was_off) {
      const std::uint16_t count = values_.template get<0x2300, 5>();
      if (count < 0xFFFF) values_.template set<0x2300, 5>(static_cast<std::uint16_t>(count + 1U));
      bus_off_age_ms_ = 0;
      if (operational()) apply_error_behaviour(app);
    }
    if (was_off && !bus_off_) report(emcy::kBusOffRecovered);
    if (bus_off_ && ++bus_off_age_ms_ >= kBusOffWait_ms) {
      bus_off_age_ms_ = 0;
      board_.can_restart();
    }
  }

  template <class App>
  void on_rpdo(const CanFrame& frame, App& app) {
    if (!operational()) return;
    const PdoRow& row = kPdos[kRpdoAt];
    if (frame.dlc != row.bytes) {
      // CiA 301 lets a node use the first bytes of one that is too long. Here it comes from a sender with another idea of the command.
      ++counters_.wrong_length;
      set_error(frame.dlc < row.bytes ? emcy::kPdoTooShort : emcy::kPdoTooLong, error_bit::kCommunication, true);
      return;
    }
    // All or nothing; a refused RPDO does not restart the deadline.
    std::array<std::uint32_t, 8> raw{};
    std::size_t at = 0;
    for (std::size_t i = 0; i < row.entries; ++i) {
      const ObjectRow& object = kRows[row.row[i]];
      raw[i] = contract::read_le(&frame.data[at], contract::object_bytes(object.type));
      at += contract::object_bytes(object.type);
      if (!in_range(object, raw[i])) {
        ++counters_.out_of_range;
        return;
      }
    }
    for (std::size_t i = 0; i < row.entries; ++i) values_.set_raw(row.row[i], raw[i]);
    rpdo_armed_ = true;
    rpdo_age_ms_ = 0;
    set_error(emcy::kPdoTooShort, error_bit::kCommunication, false);
    set_error(emcy::kPdoTooLong, error_bit::kCommunication, false);
    set_error(emcy::kRpdoDeadline, error_bit::kCommunication, false);
    app.on_rpdo();
  }
  template <class App>
  void watch_rpdo(App& app) {
    if constexpr (kHasRpdo) {
      if (!rpdo_armed_ || ++rpdo_age_ms_ < values_.template get<0x1400, 5>()) return;
      rpdo_armed_ = false;
      set_error(emcy::kRpdoDeadline, error_bit::kCommunication, true);
      app.on_rpdo_deadline();
    }
  }

  // Highest sub-index of an object that has several; 0 when the index does not exist or is a single value.
  static std::uint8_t highest_sub(std::uint16_t index) {
    std::uint8_t highest = 0;
    for (const ObjectRow& row : kRows)
      if (row.index == index && row.sub > highest) highest = row.sub;
    return highest;
  }

  [[nodiscard]] std::string_view text(std::uint16_t index) const {
    if (index == 0x1008) return device_name(kKind);
    if (index == 0x100A) return kSoftwareVersion;
    if constexpr (requires { Board::kHardwareName; })
      return Board::kHardwareName;
    else
      return board_.simulated() ? "simulated" : "unnamed";
  }

  // Writes that the stack checks for every application.
  [[nodiscard]] SdoAbort check_own_write(std::uint16_t index, std::uint8_t sub, std::uint32_t raw) const {
    if (index == 0x1010 || index == 0x1011) {
      if (raw != (index == 0x1010 ? contract::canopen::kSave : contract::canopen::kLoad)) return SdoAbort::transfer;
      // Erasing flash stops the processor: never while operational, and never with a motor under servo control.
      return state_ == NmtState::pre_operational && !bridge_on() ? SdoAbort::none : SdoAbort::device_state;
    }
    if (index == 0x1017) return raw == 0 || raw >= kHeartbeatMin_ms ? SdoAbort::none : SdoAbort::range;
    if (index == 0x1016) {  // the consumer must watch the control computer, and cannot be switched off
      const std::uint32_t time_ms = raw & 0xFFFFU;
      const bool fits = (raw >> 16) == contract::node_id(contract::Node::core) && time_ms >= kConsumerMin_ms && time_ms <= kConsumerMax_ms;
      return fits ? SdoAbort::none : SdoAbort::range;
    }
    for (const PdoRow& row : kPdos) {
      if (kRows[row.communication].index != index) continue;
      const bool tx = row.direction == contract::PdoDirection::tx;
      if (sub == 1) {
        // PDOs use 181h to 57Fh, in alternating blocks of 80h for sent and received ids; within them a command can never be mistaken for a
        // measurement (CiA 301, predefined connection set).
        const std::uint32_t id = raw & ~(contract::kPdoOffBit | contract::kPdoNoRemoteBit);
        const bool remote = tx && (raw & contract::kPdoNoRemoteBit) == 0;  // would enable answers to remote frames, which no node has
        const bool fits = id > 0x180 && id < 0x580 && (id & 0x7FU) != 0 && ((id >> 7) % 2 == 1) == tx && !remote;
        if (!fits) return SdoAbort::range;
        // A node that obeyed another node's commands would look healthy.
        if (!tx && id != (kRows[row.communication].initial & ~contract::kPdoOffBit) + node_id_) return SdoAbort::range;
        // What a node sends may be switched on and off at any time: the rates are a switch for one session.
        if (tx && ((raw ^ values_.raw(row.communication)) & ~contract::kPdoOffBit) == 0) return SdoAbort::none;
      } else if (sub == 2) {
        // Commands take effect when they come; remote requests (252, 253) do not exist.
        if ((raw > kLastSyncType && raw < 254) || (!tx && raw < 254)) return SdoAbort::range;
      }
      return state_ == NmtState::pre_operational ? SdoAbort::none : SdoAbort::device_state;
    }
    return SdoAbort::none;
  }
  // The drive's servo has the motor, be it only for the ramp to standstill.
  [[nodiscard]] bool bridge_on() const {
    if constexpr (kKind == contract::NodeKind::drive) {
      using State = contract::canopen::drive::State;
      const State now = contract::canopen::drive::state(values_.template get<0x6041>());
      return now == State::operation_enabled || now == State::quick_stop_active || now == State::fault_reaction;
    } else {
      return false;
    }
  }
  // 1010h: all parameters as they are now. 1011h: a copy without parameters, which makes the next start one with defaults.
  [[nodiscard]] SdoAbort keep_parameters(bool now) {
    const bool kept = store().save(now ? kStoredRows<kKind>.size() + 1 : 0, [&](std::size_t i) {
      if (i == 0) return StoredValue{kPlaceRecord, 0, 1, node_id_};
      const std::size_t at = kStoredRows<kKind>[i - 1];
      const ObjectRow& row = kRows[at];
      return StoredValue{row.index, row.sub, static_cast<std::uint8_t>(contract::object_bytes(row.type)), values_.raw(at)};
    });
    if (!kept) return SdoAbort::hardware;
    parameters_ok_ = true;
    set_error(emcy::kParametersLost, error_bit::kProfile, false);
    return SdoAbort::none;
  }

  // Callbacks of the SDO server: the objects of this node, and the application's final check of writes.
  template <class App>
  struct Dictionary {
    CanopenNode& node;
    App& app;

    SdoAbort sdo_read(std::uint16_t index, std::uint8_t sub, SdoSource& source) {
      const std::size_t at = find_row<kKind>(index, sub);
      if (index == 0x1003 && sub > node.values_.template get<0x1003>() && sub <= kErrorHistory) return SdoAbort::no_data;
      if (sub == 0 && (index == 0x1008 || index == 0x1009 || index == 0x100A)) {
        source.text = node.text(index);
        return SdoAbort::none;
      }
      if (at != kNoObject) {
        source.raw = node.values_.raw(at);
        source.raw_bytes = static_cast<std::uint8_t>(contract::object_bytes(kRows[at].type));
        return SdoAbort::none;
      }
      const std::uint8_t highest = highest_sub(index);
      if (sub != 0 || highest == 0) return missing(index);
      // Sub-index 0 of an array or record is the number of entries; it is in no table.
      source.raw = highest;
      source.raw_bytes = 1;
      return SdoAbort::none;
    }
    SdoAbort sdo_target(std::uint16_t index, std::uint8_t sub, SdoTarget& target) {
      const std::size_t at = find_row<kKind>(index, sub);
      if (sub == 0 && (index == 0x1008 || index == 0x1009 || index == 0x100A)) return SdoAbort::read_only;
      if (at == kNoObject) return sub == 0 && highest_sub(index) != 0 ? SdoAbort::read_only : missing(index);
      if (!kRows[at].writable) return SdoAbort::read_only;
      target.bytes = static_cast<std::uint8_t>(contract::object_bytes(kRows[at].type));
      return SdoAbort::none;
    }
    SdoAbort sdo_write(std::uint16_t index, std::uint8_t sub, std::uint32_t raw) {
      const std::size_t at = find_row<kKind>(index, sub);
      if (at == kNoObject) return SdoAbort::no_object;
      if (!in_range(kRows[at], raw)) return SdoAbort::range;
      if (const SdoAbort veto = node.check_own_write(index, sub, raw); veto != SdoAbort::none) return veto;
      if (index == contract::kProgramControl) return node.end_program(raw, app);
      if (const SdoAbort veto = app.check_write(index, sub, raw); veto != SdoAbort::none) return veto;
      if (index == 0x1010 || index == 0x1011) return node.keep_parameters(index == 0x1010);
      if (index == 0x1003) {
        for (std::size_t i = 0; i < kErrorHistory; ++i) node.values_.set_raw(kHistoryAt + i, 0);
      }
      node.values_.set_raw(at, raw);
      return SdoAbort::none;
    }
    // No node has a domain; programs are loaded by the boot loader.
    SdoAbort sdo_domain_begin(std::uint16_t, std::uint8_t, std::uint32_t) { return SdoAbort::no_object; }
    SdoAbort sdo_domain_data(std::span<const std::uint8_t>) { return SdoAbort::no_object; }
    SdoAbort sdo_domain_end() { return SdoAbort::no_object; }
    void sdo_domain_cancel() {}

    static SdoAbort missing(std::uint16_t index) {
      if (index == 0x1008 || index == 0x1009 || index == 0x100A) return SdoAbort::no_sub;
      return highest_sub(index) != 0 || find_row<kKind>(index, 0) != kNoObject ? SdoAbort::no_sub : SdoAbort::no_object;
    }
  };

  // 1F51h:1. The answer leaves first, then the board restarts into its loader. An application that moves something says in
  // standing_safely() whether it may be ended now.
  template <class App>
  SdoAbort end_program(std::uint32_t raw, App& app) {
    if constexpr (requires { board_.restart(true); }) {
      bool standing_safely = true;
      if constexpr (requires { app.standing_safely(); }) standing_safely = app.standing_safely();
      const SdoAbort veto = check_program_control(raw, state_, standing_safely);
      if (veto == SdoAbort::none) restart_in_ms_ = kProgramAnswer_ms;
      return veto;
    } else {
      return SdoAbort::device_state;
    }
  }

  template <class App>
  void on_sdo(const CanFrame& frame, App& app) {
    if (state_ == NmtState::stopped) return;
    Dictionary<App> dictionary{*this, app};
    sdo_.on_request(frame, dictionary);
    send_sdo_answer();
  }
  void send_sdo_answer() {
    if (sdo_.answer_waiting() && board_.send(sdo_.answer())) sdo_.answer_sent();
  }

  Board& board_;
  std::uint8_t node_id_;
  contract::Node node_;
  NmtState state_ = NmtState::boot_up;
  ObjectValues<kKind> values_{};
  NodeCounters counters_{};

  std::uint16_t heartbeat_age_ms_ = 0;
  bool watched_armed_ = false;
  std::uint32_t watched_age_ms_ = 0;
  bool rpdo_armed_ = false;
  std::uint32_t rpdo_age_ms_ = 0;

  std::array<std::uint32_t, kPdos.size()> pdo_sent_{};
  std::array<std::uint8_t, kPdos.size()> pdo_syncs_{};
  std::array<std::uint16_t, kPdos.size()> pdo_age_ms_{};
  std::array<bool, kPdos.size()> pdo_requested_{};

  std::array<Error, kErrorsMax> errors_{};
  std::size_t error_count_ = 0;
  std::array<Emergency, kEmcyQueueMax> emcy_{};
  std::size_t emcy_first_ = 0, emcy_count_ = 0;
  std::uint16_t emcy_age_ms_ = 0xFFFF;

  SdoServer sdo_;
  std::uint16_t restart_in_ms_ = 0;  // until the loader is entered; 0: not requested
  bool parameters_ok_ = true;
  bool bus_off_ = false;
  std::uint32_t bus_off_age_ms_ = 0, can_lost_ = 0, overrun_age_ms_ = kOverrunHold_ms;
};

}  // namespace hoist::firmware
