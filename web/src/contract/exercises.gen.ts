// Made by `deploy/dev gen` from control/contract/exercises.def; do not edit.

import type { Exercise, Words } from './rest.gen';

export interface ExerciseSizeInfo {
  name: string;
  title: Words;
  required: boolean;
  /** 0 = left out. */
  usual_m: number;
  /** Range that the hoist drives by itself. */
  driven_least_m: number;
  driven_most_m: number;
  /** At most this share of the shape's first size; 0 = no such limit. */
  share: number;
}
export interface ExerciseInfo {
  shape: Exercise['shape'];
  title: Words;
  /** May be walked clockwise too. */
  turned: boolean;
  /** May have laps. */
  closed: boolean;
  /** One lap of the usual sizes, to a millimetre. */
  usual_length_m: number;
  sizes: readonly ExerciseSizeInfo[];
}

export const exercises: readonly ExerciseInfo[] = [
  {
    shape: 'straight', title: { en: 'Straight', de: 'Gerade' }, turned: false, closed: false, usual_length_m: 10,
    sizes: [
      { name: 'length_m', title: { en: 'Length', de: 'Länge' }, required: true, usual_m: 10, driven_least_m: 0.5, driven_most_m: 100, share: 0 },],
  },
  {
    shape: 'square', title: { en: 'Square', de: 'Quadrat' }, turned: true, closed: true, usual_length_m: 12.8,
    sizes: [
      { name: 'side_m', title: { en: 'Side', de: 'Seite' }, required: true, usual_m: 3.2, driven_least_m: 0.5, driven_most_m: 100, share: 0 },
      { name: 'corner_radius_m', title: { en: 'Corners', de: 'Ecken' }, required: false, usual_m: 0, driven_least_m: 0.3, driven_most_m: 20, share: 0.5 },],
  },
  {
    shape: 'circle', title: { en: 'Circle', de: 'Kreis' }, turned: true, closed: true, usual_length_m: 9.425,
    sizes: [
      { name: 'radius_m', title: { en: 'Radius', de: 'Radius' }, required: true, usual_m: 1.5, driven_least_m: 0.3, driven_most_m: 20, share: 0 },],
  },
  {
    shape: 'eight', title: { en: 'Figure of eight', de: 'Achterfigur' }, turned: true, closed: true, usual_length_m: 10.394,
    sizes: [
      { name: 'c_m', title: { en: 'Loop spacing', de: 'Abstand der Schleifen' }, required: true, usual_m: 1, driven_least_m: 0.3, driven_most_m: 20, share: 0 },
      { name: 'radius_m', title: { en: 'Radius', de: 'Radius' }, required: true, usual_m: 0.8, driven_least_m: 0.3, driven_most_m: 20, share: 1 },],
  },
  {
    shape: 'slalom', title: { en: 'Slalom', de: 'Slalom' }, turned: true, closed: false, usual_length_m: 12.092,
    sizes: [
      { name: 'spacing_m', title: { en: 'Pole spacing', de: 'Abstand' }, required: true, usual_m: 2, driven_least_m: 1.75, driven_most_m: 10, share: 0 },],
  },
  {
    shape: 'own', title: { en: 'Own line', de: 'Eigene Linie' }, turned: false, closed: true, usual_length_m: 11.878,
    sizes: [
      { name: 'corner_radius_m', title: { en: 'Corners', de: 'Ecken' }, required: false, usual_m: 0.5, driven_least_m: 0.3, driven_most_m: 20, share: 0 },],
  },
  {
    shape: 'free', title: { en: 'Free', de: 'Frei' }, turned: false, closed: false, usual_length_m: 0,
    sizes: [],
  },
];

/** Each shape with its usual sizes. */
export const usualExercise = {
  straight: { shape: 'straight', length_m: 10 },
  square: { shape: 'square', side_m: 3.2 },
  circle: { shape: 'circle', radius_m: 1.5 },
  eight: { shape: 'eight', c_m: 1, radius_m: 0.8 },
  slalom: { shape: 'slalom', spacing_m: 2 },
  free: { shape: 'free' },
} as const satisfies { [S in Exclude<Exercise['shape'], 'own'>]: Extract<Exercise, { shape: S }> };

/** An own line for examples. */
export const usualOwnLine: Extract<Exercise, { shape: 'own' }> = { shape: 'own', closed: true, x_m: [0, 4, 4, 2, 0], y_m: [0, 0, 2, 3, 2], corner_radius_m: 0.5 };
