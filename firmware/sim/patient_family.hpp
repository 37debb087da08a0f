// Patients by their illness: one row each, chosen with `hoist-sim --patient NAME`, walked by `deploy/dev family`. Sources and what is assumed
// stand in PATIENTS.md under the same name.
#pragma once

#include <array>
#include <string_view>

#include "firmware/sim/patient.hpp"

namespace hoist::sim {

struct FamilyMember {
  std::string_view name;
  std::string_view title;
  PatientParams params;
};

inline constexpr std::array kPatientFamily{
    FamilyMember{
        "healthy",
        "walks slowly, evenly by human measure",
        {.sway_lateral_m = 0.035,
         .variation = {.stride_time_norm = 0.04, .lasting_norm = 0.7, .step_size_norm = 0.15, .within_norm = 0.1, .stand_sway_m = 0.005}}},
    FamilyMember{"stroke",
                 "hemiparesis: limps, and no step is like the other",
                 {.mass_kg = 80.0,
                  .wish_m_s = 0.25,
                  .leg_force_n = 60.0,
                  .reaction_s = 0.3,
                  .sway_lateral_m = 0.045,
                  .limp_norm = 0.35,
                  .lean_left_m = 0.02,
                  .variation = {.stride_time_norm = 0.12, .step_size_norm = 0.25, .within_norm = 0.15, .stand_sway_m = 0.010}}},
    FamilyMember{"parkinson",
                 "small quick steps that hasten and freeze",
                 {.wish_m_s = 0.35,
                  .reaction_s = 0.35,
                  .sway_forward_m = 0.008,
                  .sway_lateral_m = 0.018,
                  .sway_yaw_rad = 3.0 * kDegree_rad,
                  .stride_hz = 0.55,
                  .variation = {.stride_time_norm = 0.045,
                                .lasting_norm = 0.3,
                                .step_size_norm = 0.2,
                                .within_norm = 0.15,
                                .stand_sway_m = 0.010,
                                .freezes_per_min = 0.5,
                                .freeze_s = 4.0,
                                .festination_s = 2.5}}},
    FamilyMember{
        "ataxia",
        "wide, irregular steps",
        {.wish_m_s = 0.30,
         .sway_forward_m = 0.018,
         .sway_lateral_m = 0.045,
         .sway_yaw_rad = 8.0 * kDegree_rad,
         .stride_hz = 0.36,
         .variation = {.stride_time_norm = 0.15, .lasting_norm = 0.3, .step_size_norm = 0.4, .within_norm = 0.25, .stand_sway_m = 0.015}}},
    FamilyMember{
        "prosthesis",
        "below-knee prosthesis: fast, longer on the sound leg",
        {.wish_m_s = 0.60,
         .sway_lateral_m = 0.040,
         .limp_norm = 0.12,
         .variation = {.stride_time_norm = 0.04, .lasting_norm = 0.7, .step_size_norm = 0.2, .within_norm = 0.1, .stand_sway_m = 0.007}}},
    FamilyMember{
        "child",
        "seven years, 25 kg, quick steps",
        {.mass_kg = 25.3,
         .wish_m_s = 0.35,
         .leg_force_n = 30.0,
         .drive_n_s_m = 74.0,
         .sway_forward_m = 0.010,
         .sway_lateral_m = 0.022,
         .stride_hz = 0.62,
         .stride_hz_per_m_s = 0.35,
         .variation = {.stride_time_norm = 0.06, .lasting_norm = 0.5, .step_size_norm = 0.25, .within_norm = 0.2, .stand_sway_m = 0.008}}},
    FamilyMember{
        "heavy",
        "120 kg, wide steps",
        {.mass_kg = 120.0,
         .wish_m_s = 0.35,
         .leg_force_n = 90.0,
         .drive_n_s_m = 324.0,
         .sway_forward_m = 0.015,
         .sway_lateral_m = 0.045,
         .variation = {.stride_time_norm = 0.04, .lasting_norm = 0.7, .step_size_norm = 0.15, .within_norm = 0.1, .stand_sway_m = 0.007}}},
    FamilyMember{"slow",
                 "0.1 m/s, small steps",
                 {.wish_m_s = 0.10,
                  .sway_lateral_m = 0.035,
                  .stride_hz = 0.32,
                  .variation = {.stride_time_norm = 0.10, .step_size_norm = 0.25, .within_norm = 0.15, .stand_sway_m = 0.008}}},
    FamilyMember{
        "shuffling",
        "small steps that hardly sway",
        {.wish_m_s = 0.15,
         .reaction_s = 0.35,
         .sway_forward_m = 0.006,
         .sway_lateral_m = 0.010,
         .sway_yaw_rad = 2.0 * kDegree_rad,
         .stride_hz = 0.5,
         .variation = {.stride_time_norm = 0.06, .lasting_norm = 0.3, .step_size_norm = 0.25, .within_norm = 0.15, .stand_sway_m = 0.008}}},
    FamilyMember{"standing",
                 "walks a little, stops and stands swaying",
                 {.wish_m_s = 0.25,
                  .variation = {.stride_time_norm = 0.06,
                                .step_size_norm = 0.2,
                                .within_norm = 0.1,
                                .stand_sway_m = 0.030,
                                .rests_per_min = 2.0,
                                .rest_s = 12.0}}},
    FamilyMember{"one-sided",
                 "leans to the left all along",
                 {.wish_m_s = 0.25,
                  .sway_lateral_m = 0.035,
                  .limp_norm = 0.15,
                  .lean_left_m = 0.07,
                  .variation = {.stride_time_norm = 0.08, .step_size_norm = 0.2, .within_norm = 0.15, .stand_sway_m = 0.010}}},
};

constexpr const FamilyMember* find_patient(std::string_view name) {
  for (const FamilyMember& member : kPatientFamily)
    if (member.name == name) return &member;
  return nullptr;
}

}  // namespace hoist::sim
