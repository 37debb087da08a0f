// Made by `deploy/dev gen` from db/metrics/metric_list.hpp; do not edit.

import type { Words } from './rest.gen';

export type MetricKey =
  | 'task_time_s'
  | 'task_distance_m'
  | 'timed_speed_m_s'
  | 'out_time_s'
  | 'turning_time_s'
  | 'back_time_s'
  | 'C'
  | 'C_best'
  | 'C_best_lag_s'
  | 'J_N'
  | 'J_T_m_s'
  | 'reference_length_m'
  | 'rms_pose_m'
  | 'rms_position_m'
  | 'rms_lateral_m'
  | 'rms_heading_rad'
  | 'cross_track_mean_m'
  | 'cross_track_max_m'
  | 'completion_norm'
  | 'lap_time_mean_s'
  | 'lap_time_best_s'
  | 'under_way_s'
  | 'motion_s'
  | 'missing_s'
  | 'walked_m'
  | 'mean_speed_m_s'
  | 'max_speed_m_s'
  | 'bouts'
  | 'walking_s'
  | 'walking_speed_m_s'
  | 'stops'
  | 'steps'
  | 'interventions'
  | 'protective_stops'
  | 'patient_led_norm'
  | 'cadence_steps_min'
  | 'stride_time_s'
  | 'stride_regularity_norm'
  | 'step_regularity_norm'
  | 'step_symmetry_norm'
  | 'stride_time_cv_norm'
  | 'step_asymmetry_norm'
  | 'sparc'
  | 'ldlj'
  | 'turns_left'
  | 'turns_right'
  | 'turn_angle_rad'
  | 'turn_time_s'
  | 'turn_lead_s'
  | 'start_latency_s'
  | 'stopping_way_m'
  | 'dead_band_norm'
  | 'effort_s_m'
  | 'balance_events';

export interface MetricInfo {
  key: MetricKey;
  group: MetricGroup;
  title: Words;
  /** On screens: value times factor, so many digits, then the unit. */
  unit: string;
  factor: number;
  digits: number;
}

export type MetricGroup = 'task' | 'path' | 'dose' | 'stride' | 'smoothness' | 'turning' | 'control';

export const metricGroups: readonly { name: MetricGroup; title: Words }[] = [
  { name: 'task', title: { en: 'Task', de: 'Aufgabe' } },
  { name: 'path', title: { en: 'Path', de: 'Weg' } },
  { name: 'dose', title: { en: 'Amount', de: 'Umfang' } },
  { name: 'stride', title: { en: 'Steps', de: 'Schritte' } },
  { name: 'smoothness', title: { en: 'Smoothness', de: 'Gleichmaß' } },
  { name: 'turning', title: { en: 'Turning', de: 'Drehen' } },
  { name: 'control', title: { en: 'Leading the hoist', de: 'Führen des Geräts' } },
];

export const metrics: readonly MetricInfo[] = [
  {
    key: 'task_time_s', group: 'task', title: { en: 'Time of the task', de: 'Zeit der Aufgabe' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'task_distance_m', group: 'task', title: { en: 'Distance of the task', de: 'Strecke der Aufgabe' },
    unit: 'm', factor: 1, digits: 1,
  },
  {
    key: 'timed_speed_m_s', group: 'task', title: { en: 'Speed over the timed part', de: 'Tempo auf der Messstrecke' },
    unit: 'm/s', factor: 1, digits: 2,
  },
  {
    key: 'out_time_s', group: 'task', title: { en: 'Time of the way out', de: 'Zeit für den Hinweg' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'turning_time_s', group: 'task', title: { en: 'Time of the turn', de: 'Zeit für die Wende' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'back_time_s', group: 'task', title: { en: 'Time of the way back', de: 'Zeit für den Rückweg' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'C', group: 'path', title: { en: 'Turning with the path', de: 'Drehen mit dem Weg' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'C_best', group: 'path', title: { en: 'Turning with the path, best shift', de: 'Drehen mit dem Weg, beste Verschiebung' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'C_best_lag_s', group: 'path', title: { en: 'Pelvis turns before the path by', de: 'Becken dreht vor dem Weg um' },
    unit: 's', factor: 1, digits: 2,
  },
  {
    key: 'J_N', group: 'path', title: { en: 'Path error score', de: 'Wegfehler, Punktzahl' },
    unit: '', factor: 1, digits: 1,
  },
  {
    key: 'J_T_m_s', group: 'path', title: { en: 'Path error over time', de: 'Wegfehler über die Zeit' },
    unit: 'm s', factor: 1, digits: 2,
  },
  {
    key: 'reference_length_m', group: 'path', title: { en: 'Way along the exercise', de: 'Weg entlang der Übung' },
    unit: 'm', factor: 1, digits: 1,
  },
  {
    key: 'rms_pose_m', group: 'path', title: { en: 'Typical error, path and heading', de: 'Typischer Fehler, Weg und Richtung' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'rms_position_m', group: 'path', title: { en: 'Typical path error', de: 'Typischer Wegfehler' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'rms_lateral_m', group: 'path', title: { en: 'Typical sideways error', de: 'Typischer seitlicher Fehler' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'rms_heading_rad', group: 'path', title: { en: 'Typical heading error', de: 'Typischer Richtungsfehler' },
    unit: '°', factor: 57.29577951308232, digits: 0,
  },
  {
    key: 'cross_track_mean_m', group: 'path', title: { en: 'Mean distance from the path', de: 'Mittlerer Abstand vom Weg' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'cross_track_max_m', group: 'path', title: { en: 'Largest distance from the path', de: 'Größter Abstand vom Weg' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'completion_norm', group: 'path', title: { en: 'Exercise walked', de: 'Übung gegangen' },
    unit: '%', factor: 100, digits: 0,
  },
  {
    key: 'lap_time_mean_s', group: 'path', title: { en: 'Time for one lap, mean', de: 'Zeit für eine Runde, Mittel' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'lap_time_best_s', group: 'path', title: { en: 'Time for one lap, shortest', de: 'Zeit für eine Runde, kürzeste' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'under_way_s', group: 'dose', title: { en: 'Total time', de: 'Gesamtzeit' },
    unit: 's', factor: 1, digits: 0,
  },
  {
    key: 'motion_s', group: 'dose', title: { en: 'Time in motion', de: 'Zeit in Bewegung' },
    unit: 's', factor: 1, digits: 0,
  },
  {
    key: 'missing_s', group: 'dose', title: { en: 'Not recorded', de: 'Nicht aufgezeichnet' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'walked_m', group: 'dose', title: { en: 'Distance', de: 'Strecke' },
    unit: 'm', factor: 1, digits: 1,
  },
  {
    key: 'mean_speed_m_s', group: 'dose', title: { en: 'Mean speed in motion', de: 'Mittleres Tempo in Bewegung' },
    unit: 'm/s', factor: 1, digits: 2,
  },
  {
    key: 'max_speed_m_s', group: 'dose', title: { en: 'Largest speed', de: 'Größtes Tempo' },
    unit: 'm/s', factor: 1, digits: 2,
  },
  {
    key: 'bouts', group: 'dose', title: { en: 'Bouts of walking', de: 'Gehphasen' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'walking_s', group: 'dose', title: { en: 'Time walking', de: 'Gehzeit' },
    unit: 's', factor: 1, digits: 0,
  },
  {
    key: 'walking_speed_m_s', group: 'dose', title: { en: 'Mean speed while walking', de: 'Mittleres Gehtempo' },
    unit: 'm/s', factor: 1, digits: 2,
  },
  {
    key: 'stops', group: 'dose', title: { en: 'Pauses', de: 'Pausen' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'steps', group: 'dose', title: { en: 'Steps', de: 'Schritte' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'interventions', group: 'dose', title: { en: 'Patient\'s lead broken off', de: 'Führung des Patienten beendet' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'protective_stops', group: 'dose', title: { en: 'Protective stops', de: 'Schutzhalte' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'patient_led_norm', group: 'dose', title: { en: 'Led by the patient', de: 'Vom Patienten geführt' },
    unit: '%', factor: 100, digits: 0,
  },
  {
    key: 'cadence_steps_min', group: 'stride', title: { en: 'Steps a minute', de: 'Schritte je Minute' },
    unit: '/min', factor: 1, digits: 0,
  },
  {
    key: 'stride_time_s', group: 'stride', title: { en: 'Time of a stride', de: 'Dauer eines Doppelschritts' },
    unit: 's', factor: 1, digits: 2,
  },
  {
    key: 'stride_regularity_norm', group: 'stride', title: { en: 'Regularity of strides', de: 'Gleichmaß der Doppelschritte' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'step_regularity_norm', group: 'stride', title: { en: 'Regularity of steps', de: 'Gleichmaß der Schritte' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'step_symmetry_norm', group: 'stride', title: { en: 'Step against stride regularity', de: 'Gleichmaß Schritt zu Doppelschritt' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'stride_time_cv_norm', group: 'stride', title: { en: 'Variability of stride time', de: 'Schwankung der Schrittdauer' },
    unit: '%', factor: 100, digits: 1,
  },
  {
    key: 'step_asymmetry_norm', group: 'stride', title: { en: 'Asymmetry of steps', de: 'Asymmetrie der Schritte' },
    unit: '%', factor: 100, digits: 0,
  },
  {
    key: 'sparc', group: 'smoothness', title: { en: 'Smoothness of speed, SPARC', de: 'Gleichmaß des Tempos, SPARC' },
    unit: '', factor: 1, digits: 2,
  },
  {
    key: 'ldlj', group: 'smoothness', title: { en: 'Smoothness of speed, LDLJ', de: 'Gleichmaß des Tempos, LDLJ' },
    unit: '', factor: 1, digits: 1,
  },
  {
    key: 'turns_left', group: 'turning', title: { en: 'Turns to the left', de: 'Drehungen nach links' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'turns_right', group: 'turning', title: { en: 'Turns to the right', de: 'Drehungen nach rechts' },
    unit: '', factor: 1, digits: 0,
  },
  {
    key: 'turn_angle_rad', group: 'turning', title: { en: 'Angle of a turn', de: 'Winkel einer Drehung' },
    unit: '°', factor: 57.29577951308232, digits: 0,
  },
  {
    key: 'turn_time_s', group: 'turning', title: { en: 'Time of a turn', de: 'Dauer einer Drehung' },
    unit: 's', factor: 1, digits: 1,
  },
  {
    key: 'turn_lead_s', group: 'turning', title: { en: 'Pelvis turns before the hoist by', de: 'Becken dreht vor dem Gerät um' },
    unit: 's', factor: 1, digits: 2,
  },
  {
    key: 'start_latency_s', group: 'control', title: { en: 'Delay of setting off', de: 'Verzögerung beim Losgehen' },
    unit: 's', factor: 1, digits: 2,
  },
  {
    key: 'stopping_way_m', group: 'control', title: { en: 'Stopping distance', de: 'Anhalteweg' },
    unit: 'cm', factor: 100, digits: 0,
  },
  {
    key: 'dead_band_norm', group: 'control', title: { en: 'Lean within the dead band', de: 'Neigung in der Totzone' },
    unit: '%', factor: 100, digits: 0,
  },
  {
    key: 'effort_s_m', group: 'control', title: { en: 'Lean held per metre', de: 'Neigung je Meter' },
    unit: 's/m', factor: 1, digits: 2,
  },
  {
    key: 'balance_events', group: 'control', title: { en: 'Losses of balance', de: 'Gleichgewichtsverluste' },
    unit: '', factor: 1, digits: 0,
  },
];
