// Wiring of the STM32F072CB boards (LQFP48). Data only, no register. The circuits around are those of the LPC11C24 boards
// (lpc11c24/pins.hpp): same straps, bridge, current amplifier, dividers, contacts. What differs: an 8 MHz crystal, an external CAN
// transceiver (its silent or standby pin to ground), a converter of 12 bit. AF is the alternate function (data sheet, tables 15 and 16).
#pragma once
#include <cstdint>

namespace hoist::firmware::stm32f072 {

struct Pin {
  char port = 'A';
  std::uint8_t bit = 0;
};

// ---- every board
inline constexpr Pin kCanRx{'B', 8}, kCanTx{'B', 9};      // AF4
inline constexpr Pin kStrap0{'B', 12}, kStrap1{'B', 13};  // to ground: left, right; both: base
inline constexpr Pin kService{'B', 14};                   // to ground at reset: stays in the loader
inline constexpr Pin kLed{'C', 13};                       // low = on

// ---- tilt
inline constexpr Pin kI2cScl{'B', 6}, kI2cSda{'B', 7};  // AF1
inline constexpr std::uint8_t kMpu6050Address = 0x68;
inline constexpr Pin kSpiSck{'A', 5}, kSpiMiso{'A', 6}, kSpiMosi{'A', 7};  // AF0
inline constexpr Pin kSpiSelect{'A', 4};

// ---- drive
inline constexpr Pin kBridgeEnable{'A', 8};  // AF2: TIM1_CH1
inline constexpr Pin kBridgePhase{'B', 0};
inline constexpr Pin kBridgeAwake{'B', 1};
inline constexpr Pin kBridgeFault{'B', 2};
inline constexpr Pin kEncoderA{'A', 6}, kEncoderB{'A', 7};  // AF1: TIM3_CH1 and CH2 count
// The same two lines again, for the edge times: TIM2_CH1 and CH2 (AF2). TIM2_CH3 belongs to the same exclusive-or: PA2 open.
inline constexpr Pin kEdgeA{'A', 0}, kEdgeB{'A', 1}, kEdgeOpen{'A', 2};
inline constexpr Pin kMotorCurrent{'A', 4}, kBusVoltage{'A', 5};  // ADC_IN4, ADC_IN5
inline constexpr std::uint8_t kMotorCurrentChannel = 4, kBusVoltageChannel = 5;

inline constexpr float kAdcReference_v = 3.3F;
inline constexpr float kAdcCounts = 4096.0F;
inline constexpr float kCurrentGain_v_a = 0.060F;
inline constexpr float kCurrent_a_per_count = kAdcReference_v / kAdcCounts / kCurrentGain_v_a;  // 0.0134 A
inline constexpr float kBusDivider = 11.0F;
inline constexpr float kBus_v_per_count = kBusDivider * kAdcReference_v / kAdcCounts;

// ---- io
inline constexpr Pin kBumperFront{'A', 0}, kBumperRear{'A', 1}, kBumperLeft{'A', 2}, kBumperRight{'A', 3};
// Bit 0 of the object: a contact of the emergency stop chain, to ground, open when it is pressed. Bits 1 to 3: closed to ground = 1.
inline constexpr Pin kSwitch0{'B', 5}, kSwitch1{'B', 10}, kSwitch2{'B', 11}, kSwitch3{'B', 15};
inline constexpr Pin kOutput0{'A', 6}, kOutput1{'A', 7}, kOutput2{'A', 8}, kOutput3{'B', 0}, kOutput4{'B', 1}, kOutput5{'B', 2},
    kOutput6{'B', 6}, kOutput7{'B', 7};
inline constexpr Pin kBatteryA{'A', 4}, kBatteryBoth{'A', 5};
inline constexpr std::uint8_t kBatteryAChannel = 4, kBatteryBothChannel = 5;
inline constexpr float kBatteryADivider = 5.7F;
inline constexpr float kBatteryBothDivider = 11.0F;

// ---- gateway
inline constexpr Pin kUartTxd{'A', 9}, kUartRxd{'A', 10}, kUartCts{'A', 11}, kUartRts{'A', 12};  // AF1
inline constexpr std::uint32_t kUart_baud = 1'000'000;

}  // namespace hoist::firmware::stm32f072
