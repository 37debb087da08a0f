#include "control/bus/pokeys/device.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::bus::pokeys {

void Device::close(std::uint64_t now_ns, const char* why, std::uint64_t rest_ns) {
  transport_.close();
  stage_ = Stage::closed;
  asked_ = false;
  problem_ = why;
  open_at_ns_ = now_ns + rest_ns;
}

void Device::ask(CommandCode command, std::uint8_t parameter, std::uint64_t now_ns) {
  command_ = command;
  asked_ = true;
  asked_ns_ = now_ns;
  ++id_;
  const bool sets = command == CommandCode::inputs && wiring_.sync_pin != 0;
  const Packet request = sets ? make_output_request(wiring_.sync_pin, sync_, id_) : make_request(command, parameter, id_);
  if (!transport_.send(request)) close(now_ns, "the device has gone away", kRetryNs);
}

void Device::step(std::uint64_t now_ns) {
  if (stage_ == Stage::closed && now_ns >= open_at_ns_) {
    if (const char* why = transport_.open()) {
      close(now_ns, why, kRetryNs);
    } else {
      ++counters_.opened;
      stage_ = Stage::identify;
      answered_ns_ = now_ns;
      problem_ = "the device does not answer";
    }
  }
  for (int i = 0; stage_ != Stage::closed && i < kPacketsPerStep; ++i) {
    Packet packet{};
    const Received received = transport_.receive(packet);
    if (received == Received::nothing) break;
    if (received == Received::gone) {
      close(now_ns, "the device has gone away", kRetryNs);
    } else if (received == Received::wrong_size) {
      ++counters_.refused;
    } else {
      take(packet, now_ns);
    }
  }
  if (stage_ != Stage::closed && asked_ && now_ns - asked_ns_ >= kAnswerNs) {
    ++counters_.unanswered;
    asked_ = false;
  }
  if (stage_ != Stage::closed && now_ns - answered_ns_ >= kSilenceNs) close(now_ns, "the device does not answer", kRetryNs);
  if (stage_ != Stage::closed && !asked_) {
    if (stage_ == Stage::identify) {
      ask(CommandCode::identity, 0, now_ns);
    } else if (stage_ == Stage::pins) {
      ask(CommandCode::pin_functions, 0, now_ns);
    } else if (now_ns >= inputs_at_ns_) {
      // A late poll is not caught up.
      inputs_at_ns_ = std::max(inputs_at_ns_ + kInputsEveryNs, now_ns);
      ask(CommandCode::inputs, 0, now_ns);
    } else if (now_ns >= analogue_at_ns_) {
      analogue_at_ns_ = std::max(analogue_at_ns_ + kAnalogueEveryNs, now_ns);
      ask(CommandCode::analogue, 1, now_ns);
    }
  }
  next_ns_ = stage_ == Stage::closed ? open_at_ns_
             : asked_                ? asked_ns_ + kAnswerNs
                                     : std::min(inputs_at_ns_, std::max(analogue_at_ns_, now_ns));
}

void Device::take(const Packet& packet, std::uint64_t now_ns) {
  switch (check_reply(packet, command_, id_)) {
    case ReplyCheck::good:
      break;
    case ReplyCheck::other_id:
    case ReplyCheck::other_command:
      // A valid reply to an outdated request.
      ++counters_.late;
      return;
    default:
      ++counters_.refused;
      return;
  }
  if (!asked_) {
    ++counters_.late;
    return;
  }
  asked_ = false;
  answered_ns_ = now_ns;
  ++counters_.replies;
  switch (stage_) {
    case Stage::identify:
      if (!is_pokeys(packet)) return close(now_ns, "what answers is no PoKeys57", kWrongDeviceNs);
      stage_ = Stage::pins;
      return;
    case Stage::pins:
      if (const char* wrong = check_pins(packet)) return close(now_ns, wrong, kWrongDeviceNs);
      stage_ = Stage::running;
      inputs_at_ns_ = analogue_at_ns_ = now_ns;
      problem_ = "";
      return;
    case Stage::running:
      if (command_ == CommandCode::inputs)
        take_inputs(packet);
      else
        take_analogue(packet);
      return;
    case Stage::closed:
      return;
  }
}

const char* Device::check_pins(const Packet& packet) const {
  const auto function = [&packet](std::uint8_t pin) { return packet[kData + static_cast<std::size_t>(pin - 1)]; };
  for (const std::uint8_t pin : wiring_.bumper_pins)
    if ((function(pin) & (kDigitalInput | kDigitalOutput | kInverted)) != kDigitalInput)
      return "a pin of a bumper is not set as a digital input, not inverted (with an inverted one a torn-off wire would go unseen)";
  for (const std::uint8_t pin : wiring_.switch_pins)
    if ((function(pin) & (kDigitalInput | kDigitalOutput)) != kDigitalInput) return "a pin of a switch is not set as a digital input";
  for (const std::uint8_t pin : wiring_.battery_pins)
    if ((function(pin) & kAnalogueInput) == 0) return "a pin of a battery is not set as an analogue input";
  if (wiring_.sync_pin != 0 && (function(wiring_.sync_pin) & (kDigitalInput | kDigitalOutput)) != kDigitalOutput)
    return "the pin of the synchronisation output is not set as a digital output";
  return nullptr;
}

void Device::take_inputs(const Packet& packet) {
  readings_.bumpers = readings_.switches = 0;
  for (std::size_t i = 0; i < wiring_.bumper_pins.size(); ++i)
    readings_.bumpers = static_cast<std::uint8_t>(readings_.bumpers | (pin_level(packet, wiring_.bumper_pins[i]) ? 1U << i : 0U));
  for (std::size_t i = 0; i < wiring_.switch_pins.size(); ++i)
    readings_.switches = static_cast<std::uint8_t>(readings_.switches | (pin_level(packet, wiring_.switch_pins[i]) ? 1U << i : 0U));
  // As old as the request: the device read its pins some time after it.
  readings_.inputs_ns = asked_ns_;
}

void Device::take_analogue(const Packet& packet) {
  std::array<std::uint16_t, 2> volts{};
  for (std::size_t i = 0; i < wiring_.battery_pins.size(); ++i) {
    const std::uint16_t counts = analogue_counts(packet, wiring_.battery_pins[i]);
    if (counts > kAnalogueFull) {
      ++counters_.refused;
      return;
    }
    volts[i] = static_cast<std::uint16_t>(std::lround(counts * wiring_.full_scale_v * 100.0 / kAnalogueFull));
  }
  readings_.battery_10mv = volts;
  readings_.batteries_ns = asked_ns_;
}

}  // namespace hoist::bus::pokeys
