// What is soldered to which pin of the LPC11C24 boards, and what one count of a converter means. Data only, no register: a bench on this
// computer that plays the outside of the pins reads the same table as the drivers.
//
// One circuit per node kind, all with: 12 MHz crystal, CAN on the chip's own transceiver (CANH, CANL, STB to ground, VCC 5 V), SWD on
// PIO0_10 and PIO1_3, reset on PIO0_0. PIO0_1 is pulled up: low at reset starts the factory's serial loader. Function
// numbers are the FUNC field of the pin's IOCON register (UM10398, chapter 7).
#pragma once
#include <cstdint>

namespace hoist::firmware::lpc11c24 {

struct Pin {
  std::uint8_t port = 0;
  std::uint8_t bit = 0;
};

// ---- every board

// The place of a board: a wire from a strap to ground, read once at start with pull-ups on. A cut wire must never turn a left board into a
// right one, so each place has its own pattern, and a board without any wire stays off the bus.
//   tilt and drive   left: strap 0 to ground, right: strap 1 to ground     tilt only: both to ground = base
inline constexpr Pin kStrap0{3, 0};
inline constexpr Pin kStrap1{3, 1};
// To ground at reset: the board stays in its loader with any program (firmware/boot).
inline constexpr Pin kService{0, 3};
// Lights while the program runs: low = on. Toggles once a second in normal running, eight times a second when the board refused to start.
inline constexpr Pin kLed{2, 10};

// ---- tilt: either an MPU-6050 on I2C or an LSM6DSO or ICM-42688-P on SSP0; the program detects which.

inline constexpr Pin kI2cScl{0, 4}, kI2cSda{0, 5};     // function 1, 400 kHz, external 2.2 kOhm pull-ups
inline constexpr std::uint8_t kMpu6050Address = 0x68;  // pin AD0 to ground
inline constexpr Pin kSpiSck{0, 6};                    // function 2, with SCK0_LOC = 2
inline constexpr Pin kSpiMiso{0, 8}, kSpiMosi{0, 9};   // function 1
inline constexpr Pin kSpiSelect{0, 2};                 // a GPIO, low = selected; mode 3 (CPOL 1, CPHA 1), 4 MHz

// ---- drive: DRV8701E (PH/EN) with four external transistors, 24 V

inline constexpr Pin kBridgeEnable{0, 8};  // EN, function 2: CT16B0_MAT0, 20 kHz. High = the bridge drives, low = both low sides on
inline constexpr Pin kBridgePhase{0, 9};   // PH, a GPIO: high = forward
inline constexpr Pin kBridgeAwake{2, 8};   // nSLEEP, a GPIO: low = all transistors off, the motor coasts. 4.7 kOhm to ground outside
inline constexpr Pin kBridgeFault{2, 11};  // nFAULT, open drain, low = fault; 4.7 kOhm to 3.3 V outside
inline constexpr Pin kEncoderA{2, 6}, kEncoderB{2, 7};  // 500 lines, push-pull 3.3 V. Forward: A leads B
inline constexpr Pin kMotorCurrent{0, 11};              // function 2: AD0
inline constexpr Pin kBusVoltage{1, 0};                 // function 2: AD1
inline constexpr std::uint8_t kMotorCurrentChannel = 0;
inline constexpr std::uint8_t kBusVoltageChannel = 1;

// An amplifier in the motor's own lead (3 mOhm, gain 20, middle at half the converter's supply), because the bridge's own current output
// has no sign and is invalid while the motor feeds back. More voltage = more forward current. 10 bit over 3.3 V.
inline constexpr float kAdcReference_v = 3.3F;
inline constexpr float kAdcCounts = 1024.0F;
inline constexpr float kCurrentGain_v_a = 0.060F;
inline constexpr float kCurrentZero_v = kAdcReference_v / 2;
inline constexpr float kCurrent_a_per_count = kAdcReference_v / kAdcCounts / kCurrentGain_v_a;  // 0.0537 A; range -27.5 to 27.4 A
inline constexpr float kBusDivider = 11.0F;                                                     // 100 kOhm over 10 kOhm
inline constexpr float kBus_v_per_count = kBusDivider * kAdcReference_v / kAdcCounts;           // 0.0354 V; range 0 to 36.2 V

// ---- io

// Bumpers: contacts that open when pressed, to ground, pull-ups on. A torn cable reads as pressed.
inline constexpr Pin kBumperFront{2, 0}, kBumperRear{2, 1}, kBumperLeft{2, 2}, kBumperRight{2, 3};
// Bit 0 of the object: a contact of the emergency stop chain, to ground, open when it is pressed. Bits 1 to 3: closed to ground = 1.
inline constexpr Pin kSwitch0{2, 6}, kSwitch1{2, 7}, kSwitch2{2, 8}, kSwitch3{2, 11};
// Outputs 0 to 7 of the object, high = on; low from reset on by 4.7 kOhm to ground outside.
inline constexpr Pin kOutput0{1, 4}, kOutput1{1, 5}, kOutput2{1, 6}, kOutput3{1, 7}, kOutput4{1, 8}, kOutput5{1, 10}, kOutput6{1, 11},
    kOutput7{1, 2};
// Two 12 V batteries in series: A is the lower one, measured directly; the second channel measures both together.
inline constexpr Pin kBatteryA{0, 11};    // function 2: AD0, behind 47 kOhm over 10 kOhm
inline constexpr Pin kBatteryBoth{1, 0};  // function 2: AD1, behind 100 kOhm over 10 kOhm
inline constexpr std::uint8_t kBatteryAChannel = 0;
inline constexpr std::uint8_t kBatteryBothChannel = 1;
inline constexpr float kBatteryADivider = 5.7F;
inline constexpr float kBatteryBothDivider = 11.0F;

// ---- gateway: 1 Mbaud, 8 bits, no parity, one stop bit, both handshake lines

inline constexpr Pin kUartRxd{1, 6}, kUartTxd{1, 7};  // function 1
inline constexpr Pin kUartRts{1, 5}, kUartCts{0, 7};  // function 1, low = may send
inline constexpr std::uint32_t kUart_baud = 1'000'000;

}  // namespace hoist::firmware::lpc11c24
