#include "tests/machine/board_pins.hpp"

#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/pins.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/boards/stm32f072/pins.hpp"

namespace hoist::machine {
namespace {

namespace lpc = firmware::lpc11c24;
namespace stm = firmware::stm32f072;

constexpr PinPlace place(lpc::Pin pin) { return {pin.port, pin.bit}; }
constexpr PinPlace place(stm::Pin pin) { return {static_cast<unsigned>(pin.port - 'A'), pin.bit}; }

constexpr std::array kLpcEncoderA{place(lpc::kEncoderA)}, kLpcEncoderB{place(lpc::kEncoderB)};
constexpr std::array kStmEncoderA{place(stm::kEncoderA), place(stm::kEdgeA)}, kStmEncoderB{place(stm::kEncoderB), place(stm::kEdgeB)};
constexpr std::array kLpcPulledUp{PinPlace{0, 1}};  // low at reset would start the factory's serial loader
constexpr std::array kStmI2c{place(stm::kI2cScl), place(stm::kI2cSda)};

const BoardPins kLpcBoard{
    .strap0 = place(lpc::kStrap0),
    .strap1 = place(lpc::kStrap1),
    .service = place(lpc::kService),
    .pulled_up = kLpcPulledUp,
    .pulled_up_on_tilt = {},
    .bridge_enable = place(lpc::kBridgeEnable),
    .bridge_phase = place(lpc::kBridgePhase),
    .bridge_awake = place(lpc::kBridgeAwake),
    .bridge_fault = place(lpc::kBridgeFault),
    .encoder_a = kLpcEncoderA,
    .encoder_b = kLpcEncoderB,
    .motor_current_channel = lpc::kMotorCurrentChannel,
    .bus_voltage_channel = lpc::kBusVoltageChannel,
    .current_zero_v = static_cast<double>(lpc::kCurrentZero_v),
    .current_gain_v_a = static_cast<double>(lpc::kCurrentGain_v_a),
    .bus_divider = static_cast<double>(lpc::kBusDivider),
    .spi_select = place(lpc::kSpiSelect),
    .bumpers = {place(lpc::kBumperFront), place(lpc::kBumperRear), place(lpc::kBumperLeft), place(lpc::kBumperRight)},
    .emergency_stop = place(lpc::kSwitch0),
    .outputs = {place(lpc::kOutput0), place(lpc::kOutput1), place(lpc::kOutput2), place(lpc::kOutput3), place(lpc::kOutput4),
                place(lpc::kOutput5), place(lpc::kOutput6), place(lpc::kOutput7)},
    .battery_a_channel = lpc::kBatteryAChannel,
    .battery_both_channel = lpc::kBatteryBothChannel,
    .battery_a_divider = static_cast<double>(lpc::kBatteryADivider),
    .battery_both_divider = static_cast<double>(lpc::kBatteryBothDivider),
    .uart_cts = place(lpc::kUartCts),
    .uart_baud = lpc::kUart_baud,
    .flash_base = 0,
    .ram_top = lpc::kRamStart + lpc::kRamBytes,
    .application_start = lpc::kApplicationStart,
};

const BoardPins kStmBoard{
    .strap0 = place(stm::kStrap0),
    .strap1 = place(stm::kStrap1),
    .service = place(stm::kService),
    .pulled_up = {},
    .pulled_up_on_tilt = kStmI2c,
    .bridge_enable = place(stm::kBridgeEnable),
    .bridge_phase = place(stm::kBridgePhase),
    .bridge_awake = place(stm::kBridgeAwake),
    .bridge_fault = place(stm::kBridgeFault),
    .encoder_a = kStmEncoderA,
    .encoder_b = kStmEncoderB,
    .motor_current_channel = stm::kMotorCurrentChannel,
    .bus_voltage_channel = stm::kBusVoltageChannel,
    .current_zero_v = static_cast<double>(stm::kAdcReference_v) / 2.0,  // the same circuit as on the LPC11C24
    .current_gain_v_a = static_cast<double>(stm::kCurrentGain_v_a),
    .bus_divider = static_cast<double>(stm::kBusDivider),
    .spi_select = place(stm::kSpiSelect),
    .bumpers = {place(stm::kBumperFront), place(stm::kBumperRear), place(stm::kBumperLeft), place(stm::kBumperRight)},
    .emergency_stop = place(stm::kSwitch0),
    .outputs = {place(stm::kOutput0), place(stm::kOutput1), place(stm::kOutput2), place(stm::kOutput3), place(stm::kOutput4),
                place(stm::kOutput5), place(stm::kOutput6), place(stm::kOutput7)},
    .battery_a_channel = stm::kBatteryAChannel,
    .battery_both_channel = stm::kBatteryBothChannel,
    .battery_a_divider = static_cast<double>(stm::kBatteryADivider),
    .battery_both_divider = static_cast<double>(stm::kBatteryBothDivider),
    .uart_cts = place(stm::kUartCts),
    .uart_baud = stm::kUart_baud,
    .flash_base = stm::kFlashStart,
    .ram_top = stm::kRamStart + stm::kRamBytes,
    .application_start = stm::kApplicationStart,
};

}  // namespace

const BoardPins& board_pins(contract::ImageChip chip) { return chip == contract::ImageChip::stm32f072 ? kStmBoard : kLpcBoard; }

}  // namespace hoist::machine
