#include "tests/machine/hoist_bench.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "control/core/serve/param_keeper.hpp"
#include "tests/machine/lpc11c24.hpp"
#include "tests/machine/stm32f072.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;
constexpr Time kQuantum = 4 * kMicrosecond;  // one bit: the largest offset between chips and wire
constexpr int kPlantStepsPerMillisecond = 4;
constexpr std::size_t kSerialWindow = 4;  // most characters in transit in a UART bridge

constexpr std::size_t index(Box box) { return static_cast<std::size_t>(box); }
constexpr sim::Place place_of(Box box) {
  return box == Box::tilt_left ? sim::Place::left_strut : (box == Box::tilt_right ? sim::Place::right_strut : sim::Place::chassis);
}
constexpr std::array<const char*, kBoxCount> kNames{"drive left", "drive right", "io", "tilt left", "tilt right", "tilt base", "gateway"};

// A and B of a quadrature encoder whose count has this value: forward, A leads B.
constexpr unsigned quadrature(std::int32_t count) {
  constexpr std::array<unsigned, 4> kLines{0b00, 0b01, 0b11, 0b10};  // bit 0: A, bit 1: B
  return kLines[static_cast<std::uint32_t>(count) & 3U];
}

}  // namespace

const Image& Images::OfChip::of(Box box) const {
  if (box == Box::gateway) return gateway;
  if (box == Box::io) return io;
  return box <= Box::drive_right ? drive : tilt;
}

std::optional<Image> load_image(const std::string& name, ImageChip chip) {
  const auto directory = firmware_directory();
  if (!directory) return std::nullopt;
  const bool stm = chip == ImageChip::stm32f072;
  const std::string path = *directory + "/" + name + "-" + std::string(contract::find_image_chip(static_cast<std::uint8_t>(chip))->name);
  return load_elf(path + ".elf", stm ? Stm32f072::kFlashSize : kFlashBytes, board_pins(chip).flash_base);
}

ImagesOrReason load_images() {
  if (!firmware_directory()) return {std::nullopt, "no directory with images (deploy/dev firmware builds them)"};
  Images images;
  for (const ImageChip chip : {ImageChip::lpc11c24, ImageChip::stm32f072}) {
    Images::OfChip& of = chip == ImageChip::stm32f072 ? images.stm32f072 : images.lpc11c24;
    struct Wanted {
      const char* name;
      Image* into;
    };
    for (const Wanted& wanted : {Wanted{"hoist-tilt", &of.tilt}, Wanted{"hoist-drive", &of.drive}, Wanted{"hoist-io", &of.io},
                                 Wanted{"hoist-gateway", &of.gateway}}) {
      auto image = load_image(wanted.name, chip);
      if (!image) return {std::nullopt, std::string("image missing: ") + wanted.name};
      *wanted.into = std::move(*image);
    }
  }
  return {std::move(images), {}};
}

HoistBench::HoistBench(const Images& images, const BenchOptions& options)
    : options_(options), plant_(options.plant, options.seed), patient_(options.patient, *options.scenario) {
  const contract::PathPose start = patient_.path().pose(0.0);
  plant_.place(start.x_m, start.y_m, start.psi_rad);
  supply_v_ = plant_.supply_v();
  for (std::size_t i = 0; i < kBoxCount; ++i) wire_up(static_cast<Box>(i), images.of(options.chips[i], static_cast<Box>(i)));
  if (options.through_gateway) {
    chip(Box::gateway).serial_line().set_line_baud(pins(Box::gateway).uart_baud);
    to_gateway_ = "\rC\rS5\rO\r";
  } else {
    (void)wire_.connect(host_);
  }
  chip(Box::io).drive_pin(pins(Box::io).emergency_stop, false);  // the emergency stop chain is closed
  press_bumpers();
  for (std::size_t i = 0; i < kBoxCount; ++i) {
    const bool powered = options.only ? i == index(*options.only) : options.through_gateway || i != index(Box::gateway);
    if (powered) chips_[i]->reset(ResetCause::power_on);
  }
}

// The board around the chip, as pins.hpp says it is wired.
void HoistBench::wire_up(Box box, const Image& image) {
  auto& chip = chips_[index(box)];
  const BoardPins& board = pins(box);
  const std::vector<std::uint8_t>& whole = options_.flash[index(box)];
  const std::vector<std::uint8_t>& flash = whole.empty() ? image.flash : whole;
  if (options_.chips[index(box)] == ImageChip::stm32f072)
    chip = std::make_unique<Stm32f072>(kNames[index(box)], flash);
  else
    chip = std::make_unique<Lpc11c24>(kNames[index(box)], flash);
  if (whole.empty() && image.lowest != board.flash_base) chip->start_at(image.lowest);
  for (const PinPlace line : board.pulled_up) chip->drive_pin(line, true);
  switch (box) {
    case Box::drive_left:
    case Box::drive_right:
      wire_drive(box);
      break;
    case Box::tilt_left:
    case Box::tilt_right:
    case Box::tilt_base:
      wire_tilt(box);
      break;
    case Box::io:
      chip->set_analog([this, &board](unsigned channel, Time) {
        if (channel == board.battery_a_channel) return battery_v_[0] / board.battery_a_divider;
        return (battery_v_[0] + battery_v_[1]) / board.battery_both_divider;
      });
      break;
    case Box::gateway:
      chip->drive_pin(board.uart_cts, false);
      break;
  }
  stations_[index(box)] = wire_.connect(chip->can());
}

void HoistBench::wire_drive(Box box) {
  Chip& drive = chip(box);
  const BoardPins& board = pins(box);
  const std::size_t side = index(box) - index(Box::drive_left);
  drive.drive_pin(side == 0 ? board.strap0 : board.strap1, false);
  encoder_pins_[side] = quadrature(plant_.encoder_counts(side == 0 ? sim::Side::left : sim::Side::right));
  for (const PinPlace line : board.encoder_a) drive.drive_pin(line, (encoder_pins_[side] & 1U) != 0);
  for (const PinPlace line : board.encoder_b) drive.drive_pin(line, (encoder_pins_[side] & 2U) != 0);
  drive.drive_pin(board.bridge_fault, true);
  drive.set_interlock({board.bridge_phase, board.bridge_enable, board.bridge_awake});
  drive.set_analog([this, side, &board](unsigned channel, Time) {
    if (channel == board.motor_current_channel) return board.current_zero_v + board.current_gain_v_a * motor_a_[side];
    return supply_v_ / board.bus_divider;
  });
}

void HoistBench::wire_tilt(Box box) {
  Chip& owner = chip(box);
  const BoardPins& board = pins(box);
  if (box != Box::tilt_right) owner.drive_pin(board.strap0, false);
  if (box != Box::tilt_left) owner.drive_pin(board.strap1, false);
  for (const PinPlace line : board.pulled_up_on_tilt) owner.drive_pin(line, true);
  const sim::Place place = place_of(box);
  // The chip's axes are the hoist's: x forward, y left, z up. Leaning forward turns about y, leaning right about x.
  const MotionSource motion = [this, place](Time) {
    const sim::ImuReading at = plant_.read_imu(place);
    return ChipMotion{{at.ax_m_s2, at.ay_m_s2, at.az_m_s2}, {at.beta_rate_rad_s, at.alpha_rate_rad_s, at.yaw_rate_rad_s}};
  };
  const Complain complain = [&owner](const std::string& what) { owner.complain(what); };
  auto& imu = imus_[index(box) - index(Box::tilt_left)];
  switch (options_.imus[index(box) - index(Box::tilt_left)]) {
    case ImuKind::mpu6050:
      imu = std::make_unique<Mpu6050>(motion, complain);
      owner.connect_i2c(imu.get());
      return;
    case ImuKind::lsm6dso:
      imu = std::make_unique<Lsm6dso>(motion, complain);
      break;
    case ImuKind::icm42688p:
      imu = std::make_unique<Icm42688p>(motion, complain);
      break;
  }
  owner.connect_spi(imu.get(), board.spi_select);
}

void HoistBench::press_bumpers() {
  const std::uint8_t pressed = plant_.bumpers();
  if (pressed == bumpers_) return;
  bumpers_ = pressed;
  const std::array<PinPlace, 4>& contacts = pins(Box::io).bumpers;
  for (unsigned i = 0; i < contacts.size(); ++i) {
    if ((pressed & (1U << i)) != 0)
      chip(Box::io).float_pin(contacts[i]);  // the contact opens, the pull-up shows
    else
      chip(Box::io).drive_pin(contacts[i], false);
  }
}

void HoistBench::read_bridge(Box box, sim::Side side) {
  const Chip& drive = chip(box);
  const BoardPins& board = pins(box);
  const bool awake = drive.pin_driven_by_chip(board.bridge_awake) && drive.pin(board.bridge_awake);
  const double share = drive.pin_driven_by_chip(board.bridge_enable) ? drive.pin_high_share(board.bridge_enable) : 0.0;
  const bool forward = drive.pin(board.bridge_phase);
  plant_.set_bridge(side, awake, forward ? share : -share);
}

// The counts of one plant step as edges on A and B, evenly over the next one: what the chip sees is one step late.
void HoistBench::turn_encoder(Box box, sim::Side side, std::int32_t before, Time from, Time span) {
  const auto moved =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(plant_.encoder_counts(side)) - static_cast<std::uint32_t>(before));
  const std::int32_t sense = moved < 0 ? -1 : 1;
  const std::int32_t count = moved * sense;
  unsigned& shown = encoder_pins_[side == sim::Side::left ? 0 : 1];
  for (std::int32_t i = 1; i <= count; ++i) {
    const unsigned wanted = quadrature(before + sense * i);
    const unsigned lines = (wanted & ~broken_line_[index(box)]) | (shown & broken_line_[index(box)]);
    const Time at = from + span * static_cast<Time>(i) / static_cast<Time>(count + 1);
    const unsigned changed = lines ^ shown;
    if ((changed & 1U) != 0)
      for (const PinPlace line : pins(box).encoder_a) chip(box).schedule_pin(at, line, (lines & 1U) != 0);
    if ((changed & 2U) != 0)
      for (const PinPlace line : pins(box).encoder_b) chip(box).schedule_pin(at, line, (lines & 2U) != 0);
    shown = lines;
  }
}

void HoistBench::advance_quarter() {
  constexpr Time kSpan = kMillisecond / kPlantStepsPerMillisecond;
  read_bridge(Box::drive_left, sim::Side::left);
  read_bridge(Box::drive_right, sim::Side::right);
  const std::int32_t left = plant_.encoder_counts(sim::Side::left), right = plant_.encoder_counts(sim::Side::right);
  plant_.step(patient_.harness(), 0.001 / kPlantStepsPerMillisecond);
  motor_a_ = {plant_.motor_current_a(sim::Side::left), plant_.motor_current_a(sim::Side::right)};
  supply_v_ = plant_.supply_v();
  battery_v_ = {plant_.battery_v(0), plant_.battery_v(1)};
  turn_encoder(Box::drive_left, sim::Side::left, left, now_, kSpan);
  turn_encoder(Box::drive_right, sim::Side::right, right, now_, kSpan);
  press_bumpers();
  const Time end = now_ + kSpan;
  while (now_ < end) {
    now_ = std::min(now_ + kQuantum, end);
    for (auto& chip : chips_) chip->run_until(now_);
    wire_.advance(now_);
    if (options_.through_gateway) move_serial_line();
  }
}

// The computer's end of the serial line: sends while the gateway's RTS allows, takes everything.
void HoistBench::move_serial_line() {
  const SerialLine& state = chip(Box::gateway).serial_state();
  if (!to_gateway_.empty() && state.line_waiting() < kSerialWindow && state.may_send()) {
    chip(Box::gateway).serial_line().line_send(static_cast<std::uint8_t>(to_gateway_.front()), now_);
    to_gateway_.erase(to_gateway_.begin());
  }
  if (state.received_by_line.empty()) return;
  SerialLine& uart = chip(Box::gateway).serial_line();
  while (!uart.received_by_line.empty()) {
    const char c = static_cast<char>(uart.received_by_line.front());
    uart.received_by_line.pop_front();
    decoder_.feed(std::span<const char>(&c, 1), [this](const contract::SlcanLine& line) {
      if (line.kind == contract::SlcanKind::frame) received_.push_back(line.frame);
    });
  }
}

void HoistBench::advance_1ms() {
  patient_.step_1ms({plant_.platform(), plant_.harness_force(patient_.harness()),
                     plant_.bridge_enabled(sim::Side::left) && plant_.bridge_enabled(sim::Side::right)});
  plant_.set_carried(patient_.carried_n());
  for (int i = 0; i < kPlantStepsPerMillisecond; ++i) advance_quarter();
}

void HoistBench::host_send(const CanFrame& frame) {
  if (!options_.through_gateway) {
    host_.send(frame);
    return;
  }
  std::array<char, contract::kSlcanLineMax> line{};
  to_gateway_.append(line.data(), contract::slcan_encode(frame, line));
}

std::size_t HoistBench::host_receive(std::span<CanFrame> out) {
  if (!options_.through_gateway) {
    received_.insert(received_.end(), host_.received.begin(), host_.received.end());
    host_.received.clear();
  }
  const std::size_t given = std::min(out.size(), received_.size());
  std::copy_n(received_.begin(), given, out.begin());
  received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(given));
  return given;
}

std::string HoistBench::violations() const {
  std::string out;
  for (const auto& chip : chips_)
    for (const auto& [what, count] : chip->violations()) out += chip->name() + ": " + what + " (" + std::to_string(count) + ")\n";
  return out;
}

std::uint64_t HoistBench::digest() const {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  const auto mix = [&hash](std::uint64_t value) {
    for (int i = 0; i < 8; ++i) hash = (hash ^ ((value >> (8 * i)) & 0xFFU)) * 0x100000001B3ULL;
  };
  const sim::PlatformMotion& at = plant_.platform();
  for (const double value : {at.x_m, at.y_m, at.psi_rad, at.speed_m_s, supply_v_, motor_a_[0], motor_a_[1]})
    mix(std::bit_cast<std::uint64_t>(value));
  for (const auto& chip : chips_) {
    mix(chip->core().instructions());
    mix(chip->core().cycles());
  }
  mix(wire_.frames());
  return hash;
}

// ---------------------------------------------------------------- with the core

namespace {
// These nodes report as real ones: such a hoist starts only after its struts have been zeroed and its parts checked.
contract::Params zeroed(contract::Params params) {
  params.calibrated_zero_s = params.calibrated_encoders_s = params.calibrated_bumpers_s = params.calibrated_struts_s = 1.0;
  return params;
}
}  // namespace

MachineLoop::MachineLoop(const Images& images, const BenchOptions& options, const contract::Params& params)
    : bench_(images, options), core_(std::make_unique<core::CoreState>(zeroed(params))), outputs_(std::make_unique<core::TickOutputs>()) {}

void MachineLoop::step() {
  constexpr std::uint64_t kClockStart_ns = 1'000'000'000;
  core::TickInputs inputs;
  inputs.tick = ticks_++;
  inputs.time_ns = kClockStart_ns + inputs.tick * 10'000'000ULL;
  const std::size_t got = bench_.host_receive(frames_);
  inputs.frames = std::span<const CanFrame>(frames_).first(got);
  inputs.bus_up = true;
  inputs.commands = commands_;
  inputs.server_heartbeat = ++heartbeat_;
  core::tick(*core_, inputs, core::kTick_s, *outputs_);
  commands_.clear();
  sign_parts();
  for (const CanFrame& frame : outputs_->frames) bench_.host_send(frame);
  for (const contract::Event& event : outputs_->events) events_.push_back(event);
  for (int i = 0; i < 10; ++i) bench_.advance_1ms();
}

// The last step of a technician's check: the serial numbers that it was made with.
void MachineLoop::sign_parts() {
  const auto id = static_cast<double>(core_->master.nodes_id());
  if (!core_->master.all_running() || core_->params.calibrated_nodes_id == id) return;
  core::Staging set;
  static_cast<void>(set.rows.push_back({contract::param_index(contract::ParamName::calibrated_nodes_id), id}));
  core::put_into_force(*core_, set, {}, 0);
}

void MachineLoop::run(double seconds) {
  const auto steps = std::lround(seconds / core::kTick_s);
  for (long i = 0; i < steps; ++i) step();
}
bool MachineLoop::run_until(const std::function<bool()>& done, double at_most_s) {
  const auto steps = std::lround(at_most_s / core::kTick_s);
  for (long i = 0; i < steps && !done(); ++i) step();
  return done();
}

void MachineLoop::ask(contract::CommandKind kind, std::uint32_t a, double v0, double v1, double v2) {
  contract::Command command;
  command.sequence = ++sequence_;
  command.kind = kind;
  command.request_id = ++requests_;
  command.client = kClient;
  command.lease_epoch = ticks_ > 0 ? record().lease_epoch : 0;
  command.a = a;
  command.v0 = v0;
  command.v1 = v1;
  command.v2 = v2;
  commands_.push_back(command);
}

bool MachineLoop::start(contract::Mode mode) {
  if (!run_until([this] { return this->mode() == contract::Mode::standby; }, 15.0)) return false;
  if (record().lease_holder != kClient) ask(contract::CommandKind::take_lease);
  if (!run_until([this] { return record().blocked_bits == 0; }, 10.0)) return false;
  ask(contract::CommandKind::request_mode, static_cast<std::uint32_t>(mode));
  return run_until([this, mode] { return this->mode() == mode; }, 2.0);
}

bool MachineLoop::fault(contract::Fault which) const { return ((record().fault_bits >> contract::fault_info(which).bit) & 1U) != 0; }
std::string MachineLoop::faults() const {
  std::string out;
  for (const auto& row : contract::kFaults)
    if (((record().fault_bits >> row.bit) & 1U) != 0) out += std::string(row.name) + " ";
  return out;
}

}  // namespace hoist::machine
