// THE calibration steps, and why a measurement may be refused: one row each, with the words for people. Used by the core (who may, what is
// plausible), the server and its tests. Numbers are never reused: they are in recordings.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/params.hpp"

namespace hoist::contract {

enum class CalibrationStep : std::uint8_t {
  none = 0,
  zero = 1,           // strut and chassis sensors, empty harness, level floor
  neutral = 2,        // the strapped-in patient standing at ease
  gyro = 3,           // turn rate at rest
  strut_length = 4,   // bar held at measured distances
  strut_spacing = 5,  // bar turned by measured angles
  wheel_radius = 6,   // pushed along measured distances
  track = 7,          // turned by measured turns
  square = 8,         // errors of driven squares (UMBmark)
  encoders = 9,       // pushed forward, turned left
  bumpers = 10,       // each strip pressed once
  struts = 11,        // bar moved forward, to the right, turned left
};

/// What `measure_calibration` means in `a`; only the square has two parts.
enum class CalibrationPart : std::uint32_t { whole = 0, left_square = 1, right_square = 2 };

enum class CalibrationPhase : std::uint8_t { none = 0, resting = 1, measuring = 2, operator_ = 3, result = 4, refused = 5 };

struct CalibrationStepInfo {
  CalibrationStep step;
  std::string_view name;
  Role role;
  ParamName date;
  std::string_view unit;  // of what the operator enters; empty: nothing is entered
  double least, most;     // size of what is entered; the sign is the direction
  std::uint8_t samples;   // how many at least, in both directions
  bool empty_harness;     // begins only after the operator has confirmed that nobody is strapped in
  std::string_view title_en, do_en, title_de, do_de;
};

inline constexpr std::array kCalibrationSteps{
    CalibrationStepInfo{
        CalibrationStep::zero, "zero", Role::therapist, ParamName::calibrated_zero_s, "", 0, 0, 0, true, "Struts upright",
        "Take the patient out of the harness. Put the hoist on a level floor, let the struts stand upright by themselves, and let go.",
        "Streben aufrecht",
        "Patient aus dem Gurt nehmen. Gerät auf ebenen Boden stellen, die Streben von selbst aufrecht stehen lassen und loslassen."},
    CalibrationStepInfo{CalibrationStep::neutral, "neutral", Role::therapist, ParamName::calibrated_neutral_s, "", 0, 0, 0, false,
                        "Patient's neutral posture", "Strap the patient in. Let the patient stand at ease, upright and looking ahead.",
                        "Neutrale Haltung", "Patient angurten. Der Patient steht bequem, aufrecht und schaut geradeaus."},
    CalibrationStepInfo{CalibrationStep::gyro, "gyro", Role::therapist, ParamName::calibrated_gyro_s, "", 0, 0, 0, false,
                        "Turn sensors at rest", "Let the hoist stand without touching it for five seconds.", "Drehsensoren in Ruhe",
                        "Das Gerät fünf Sekunden lang unberührt stehen lassen."},
    CalibrationStepInfo{CalibrationStep::strut_length, "strut_length", Role::engineer, ParamName::calibrated_strut_length_s, "m", 0.03,
                        0.30, 3, true, "Strut length",
                        "Empty harness. Hold the bar a measured way forward of the middle, enter it, press Measure; then about twice as "
                        "far; then as far backward.",
                        "Strebenlänge",
                        "Leerer Gurt. Den Bügel um einen gemessenen Weg nach vorn halten, eingeben, Messen drücken; dann etwa doppelt so "
                        "weit; dann ebenso weit nach hinten."},
    CalibrationStepInfo{CalibrationStep::strut_spacing, "strut_spacing", Role::engineer, ParamName::calibrated_strut_spacing_s, "rad", 0.05,
                        0.52, 3, true, "Strut spacing",
                        "Empty harness. Hold the bar turned left by a measured angle, enter it, press Measure; then about twice as far; "
                        "then as far to the right.",
                        "Strebenabstand",
                        "Leerer Gurt. Den Bügel um einen gemessenen Winkel nach links drehen, eingeben, Messen drücken; dann etwa doppelt "
                        "so weit; dann ebenso weit nach rechts."},
    CalibrationStepInfo{
        CalibrationStep::wheel_radius, "wheel_radius", Role::engineer, ParamName::calibrated_wheel_radius_s, "m", 1.0, 20.0, 2, false,
        "Wheel radius",
        "Release the brakes by hand. Push the hoist straight ahead along a measured way, enter it, press Measure; then back.", "Radradius",
        "Die Bremsen von Hand lösen. Das Gerät einen gemessenen Weg geradeaus schieben, eingeben, Messen drücken; dann zurück."},
    CalibrationStepInfo{CalibrationStep::track, "track", Role::engineer, ParamName::calibrated_track_s, "rad", 3.1, 63.0, 2, false,
                        "Track width",
                        "Release the brakes by hand. Turn the hoist on the spot by whole turns to the left, enter them, press Measure; "
                        "then to the right.",
                        "Spurweite",
                        "Die Bremsen von Hand lösen. Das Gerät auf der Stelle um ganze Drehungen nach links drehen, eingeben, Messen "
                        "drücken; dann nach rechts."},
    CalibrationStepInfo{
        CalibrationStep::square, "square", Role::engineer, ParamName::calibrated_square_s, "m", 1.0, 20.0, 2, false, "Driven squares",
        "Drive the square once turning left and once turning right. Enter how far off the shown place the hoist truly ended.",
        "Gefahrene Quadrate",
        "Das Quadrat einmal linksherum und einmal rechtsherum fahren. Eingeben, wie weit das Gerät wirklich von der angezeigten Stelle "
        "entfernt endete."},
    CalibrationStepInfo{
        CalibrationStep::encoders, "encoders", Role::engineer, ParamName::calibrated_encoders_s, "", 0, 0, 0, false, "Wheel sensors",
        "Release the brakes by hand. Push the hoist forward by half a metre, then turn it left by a quarter.", "Radgeber",
        "Die Bremsen von Hand lösen. Das Gerät einen halben Meter vorwärts schieben, dann um eine Vierteldrehung nach links drehen."},
    CalibrationStepInfo{CalibrationStep::bumpers, "bumpers", Role::therapist, ParamName::calibrated_bumpers_s, "", 0, 0, 0, false,
                        "Bumpers", "Press the bumpers one after the other: front, rear, left, right.", "Stoßfänger",
                        "Die Stoßfänger nacheinander drücken: vorn, hinten, links, rechts."},
    CalibrationStepInfo{
        CalibrationStep::struts, "struts", Role::therapist, ParamName::calibrated_struts_s, "", 0, 0, 0, true, "Strut sensors",
        "Take the patient out of the harness. Move the bar by a hand's length and hold it still: forward, to the right, turned to the "
        "left.",
        "Strebensensoren",
        "Patient aus dem Gurt nehmen. Den Bügel um eine Handlänge bewegen und stillhalten: nach vorn, nach rechts, nach links gedreht."},
};

enum class CalibrationReason : std::uint8_t {
  none = 0,
  not_still = 1,
  zero_too_large = 2,
  gyro_too_large = 3,
  still_settling = 4,
  implausible = 5,
  disagree = 6,
  too_little = 7,
  not_straight = 8,
  one_direction = 9,
  left_encoder_reversed = 10,
  right_encoder_reversed = 11,
  encoders_swapped = 12,
  left_encoder_dead = 13,
  right_encoder_dead = 14,
  bumper_swapped = 15,
  bumper_stuck = 16,
  sensor_lost = 17,
  timed_out = 18,
  cancelled = 19,
  posture_too_far = 20,
  both_backward = 21,
  bumper_dead = 22,
  turned_right = 23,
  harness_sways = 24,
  left_strut_turned = 25,
  right_strut_turned = 26,
  left_strut_askew = 27,
  right_strut_askew = 28,
  struts_swapped = 29,
  bar_other_way = 30,
};

struct CalibrationReasonInfo {
  CalibrationReason reason;
  std::string_view name, text_en, text_de;
};

inline constexpr std::array kCalibrationReasons{
    CalibrationReasonInfo{CalibrationReason::not_still, "not_still", "Something moved. Let everything rest and measure again.",
                          "Etwas hat sich bewegt. Alles ruhen lassen und neu messen."},
    CalibrationReasonInfo{CalibrationReason::zero_too_large, "zero_too_large",
                          "A sensor is more than 3° off. Is the harness empty, the floor level, every sensor screwed down?",
                          "Ein Sensor liegt mehr als 3° daneben. Ist der Gurt leer, der Boden eben, jeder Sensor fest?"},
    CalibrationReasonInfo{CalibrationReason::gyro_too_large, "gyro_too_large",
                          "The turn sensor reports more than 2.5°/s at rest: replace the chassis sensor.",
                          "Der Drehsensor meldet in Ruhe mehr als 2,5°/s: Sensor des Fahrgestells tauschen."},
    CalibrationReasonInfo{CalibrationReason::still_settling, "still_settling",
                          "The sensors are still warming up: wait two minutes and measure again.",
                          "Die Sensoren stellen sich noch ein: zwei Minuten warten und neu messen."},
    CalibrationReasonInfo{CalibrationReason::implausible, "implausible",
                          "This result is not plausible. Check the figure entered and its sign, then measure again.",
                          "Dieses Ergebnis kann nicht stimmen. Eingegebene Zahl und Vorzeichen prüfen und neu messen."},
    CalibrationReasonInfo{CalibrationReason::disagree, "disagree", "The measurements do not agree. Measure again with care.",
                          "Die Messungen passen nicht zueinander. Sorgfältig neu messen."},
    CalibrationReasonInfo{CalibrationReason::too_little, "too_little", "The motion was too small. Move it further.",
                          "Die Bewegung war zu klein. Weiter bewegen."},
    CalibrationReasonInfo{CalibrationReason::not_straight, "not_straight", "The hoist turned on the way. Push it straight, along a line.",
                          "Das Gerät hat sich unterwegs gedreht. Gerade schieben, an einer Linie entlang."},
    CalibrationReasonInfo{CalibrationReason::one_direction, "one_direction", "One direction is missing: measure both ways.",
                          "Eine Richtung fehlt: in beide Richtungen messen."},
    CalibrationReasonInfo{CalibrationReason::left_encoder_reversed, "left_encoder_reversed",
                          "The left wheel counts backward: swap lines A and B of its encoder.",
                          "Das linke Rad zählt rückwärts: Leitungen A und B seines Gebers tauschen."},
    CalibrationReasonInfo{CalibrationReason::right_encoder_reversed, "right_encoder_reversed",
                          "The right wheel counts backward: swap lines A and B of its encoder.",
                          "Das rechte Rad zählt rückwärts: Leitungen A und B seines Gebers tauschen."},
    CalibrationReasonInfo{CalibrationReason::encoders_swapped, "encoders_swapped",
                          "The wheels are swapped: the left drive sits on the right wheel. Swap their encoder plugs.",
                          "Die Räder sind vertauscht: der linke Antrieb sitzt am rechten Rad. Geberstecker tauschen."},
    CalibrationReasonInfo{CalibrationReason::left_encoder_dead, "left_encoder_dead",
                          "The left wheel counts nothing: check the plug of its encoder.",
                          "Das linke Rad zählt nicht: Stecker seines Gebers prüfen."},
    CalibrationReasonInfo{CalibrationReason::right_encoder_dead, "right_encoder_dead",
                          "The right wheel counts nothing: check the plug of its encoder.",
                          "Das rechte Rad zählt nicht: Stecker seines Gebers prüfen."},
    CalibrationReasonInfo{CalibrationReason::bumper_swapped, "bumper_swapped",
                          "Another bumper answered: the plugs are swapped, or the wrong one was pressed.",
                          "Ein anderer Stoßfänger hat geantwortet: Stecker vertauscht oder falscher gedrückt."},
    CalibrationReasonInfo{CalibrationReason::bumper_stuck, "bumper_stuck",
                          "A bumper reports pressed although it is not touched: free it, check its plug.",
                          "Ein Stoßfänger meldet gedrückt, obwohl ihn niemand berührt: lösen, Stecker prüfen."},
    CalibrationReasonInfo{CalibrationReason::sensor_lost, "sensor_lost", "A sensor or drive stopped answering: check its plug.",
                          "Ein Sensor oder Antrieb antwortet nicht mehr: Stecker prüfen."},
    CalibrationReasonInfo{CalibrationReason::timed_out, "timed_out", "Nothing happened for a minute. The old values stay.",
                          "Eine Minute lang geschah nichts. Die alten Werte bleiben."},
    CalibrationReasonInfo{CalibrationReason::cancelled, "cancelled", "Cancelled. The old values stay.",
                          "Abgebrochen. Die alten Werte bleiben."},
    CalibrationReasonInfo{CalibrationReason::posture_too_far, "posture_too_far",
                          "The patient stands too far from the middle: shift the harness and measure again.",
                          "Der Patient steht zu weit außerhalb der Mitte: Gurt verschieben und neu messen."},
    CalibrationReasonInfo{CalibrationReason::both_backward, "both_backward",
                          "Both wheels counted backward. Push forward; if you did, swap lines A and B of both encoders.",
                          "Beide Räder zählten rückwärts. Vorwärts schieben; war es vorwärts, Leitungen A und B beider Geber tauschen."},
    CalibrationReasonInfo{CalibrationReason::bumper_dead, "bumper_dead", "A bumper did not answer within a minute: check its plug.",
                          "Ein Stoßfänger hat eine Minute lang nicht geantwortet: Stecker prüfen."},
    CalibrationReasonInfo{CalibrationReason::turned_right, "turned_right", "The hoist was turned to the right. Turn it to the left.",
                          "Das Gerät wurde nach rechts gedreht. Nach links drehen."},
    CalibrationReasonInfo{CalibrationReason::harness_sways, "harness_sways",
                          "The harness sways. Take the patient out, let the struts rest, measure again.",
                          "Der Gurt bewegt sich. Patienten herausnehmen, Streben ruhen lassen, neu messen."},
    CalibrationReasonInfo{CalibrationReason::left_strut_turned, "left_strut_turned",
                          "The left strut's sensor shows the opposite: it is screwed on the wrong way round. Turn it.",
                          "Der Sensor der linken Strebe zeigt das Gegenteil: er ist verkehrt herum angeschraubt. Umdrehen."},
    CalibrationReasonInfo{CalibrationReason::right_strut_turned, "right_strut_turned",
                          "The right strut's sensor shows the opposite: it is screwed on the wrong way round. Turn it.",
                          "Der Sensor der rechten Strebe zeigt das Gegenteil: er ist verkehrt herum angeschraubt. Umdrehen."},
    CalibrationReasonInfo{CalibrationReason::left_strut_askew, "left_strut_askew",
                          "The left strut's sensor did not follow the bar. Is it screwed down, straight and on its strut?",
                          "Der Sensor der linken Strebe ist dem Bügel nicht gefolgt. Sitzt er fest, gerade und an seiner Strebe?"},
    CalibrationReasonInfo{CalibrationReason::right_strut_askew, "right_strut_askew",
                          "The right strut's sensor did not follow the bar. Is it screwed down, straight and on its strut?",
                          "Der Sensor der rechten Strebe ist dem Bügel nicht gefolgt. Sitzt er fest, gerade und an seiner Strebe?"},
    CalibrationReasonInfo{CalibrationReason::struts_swapped, "struts_swapped",
                          "The bar was turned to the right. If you turned it left, the strut sensors are swapped: exchange them.",
                          "Der Bügel wurde nach rechts gedreht. War es nach links, sind die Strebensensoren vertauscht: austauschen."},
    CalibrationReasonInfo{CalibrationReason::bar_other_way, "bar_other_way",
                          "The bar moved another way than asked. If it did not, both strut sensors are screwed on wrongly.",
                          "Der Bügel wurde anders bewegt als verlangt. Wenn nicht, sind beide Strebensensoren falsch angeschraubt."},
};

static_assert(unique_by(kCalibrationSteps, [](const CalibrationStepInfo& s) { return s.step; }) &&
                  all_rows(kCalibrationSteps,
                           [](const CalibrationStepInfo& s) {
                             return kCalibrationSteps[static_cast<std::size_t>(s.step) - 1].step == s.step && !s.title_en.empty() &&
                                    !s.do_en.empty() && !s.title_de.empty() && !s.do_de.empty();
                           }),
              "calibration.hpp: steps must be numbered in order and have their words");
static_assert(all_rows(kCalibrationReasons,
                       [](const CalibrationReasonInfo& r) {
                         return kCalibrationReasons[static_cast<std::size_t>(r.reason) - 1].reason == r.reason && !r.text_en.empty() &&
                                !r.text_de.empty();
                       }),
              "calibration.hpp: reasons must be numbered in order and have their words");

constexpr const CalibrationStepInfo* find_calibration_step(std::uint32_t number) {
  return number == 0 || number > kCalibrationSteps.size() ? nullptr : &kCalibrationSteps[number - 1];
}
constexpr const CalibrationStepInfo* find_calibration_step(std::string_view name) {
  for (const CalibrationStepInfo& row : kCalibrationSteps)
    if (row.name == name) return &row;
  return nullptr;
}
constexpr const CalibrationReasonInfo* find_calibration_reason(std::uint32_t number) {
  return number == 0 || number > kCalibrationReasons.size() ? nullptr : &kCalibrationReasons[number - 1];
}

}  // namespace hoist::contract
