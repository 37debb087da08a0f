// Names of exercises and of their sizes, out of the table of exercises.
import { exercises, type ExerciseInfo, type ExerciseSizeInfo } from '../contract/exercises.gen';
import type { Exercise } from '../contract/rest.gen';
import { words } from './text';

export const exerciseRow = (shape: Exercise['shape']): ExerciseInfo => exercises.find((row) => row.shape === shape)!;

export const exerciseTitle = (shape: Exercise['shape']): string => words(exerciseRow(shape).title);

/** The size that a shape is chosen by: its first one. */
export const firstSize = (shape: Exclude<Exercise['shape'], 'free' | 'own'>): ExerciseSizeInfo => exerciseRow(shape).sizes[0]!;
