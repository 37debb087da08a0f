// The list of screens, in the order of the menu. To add one: a folder beside this file and one row here.
import { calibratePanel } from './calibrate/calibrate';
import { drivePanel } from './drive/drive';
import { exercisesPanel } from './exercises/exercises';
import { healthPanel } from './health/health';
import type { Panel } from './panel';
import { sessionsPanel } from './sessions/sessions';
import { tunePanel } from './tune/tune';
import { walkPanel } from './walk/walk';

export const panels: readonly Panel[] = [walkPanel, drivePanel, exercisesPanel, tunePanel, sessionsPanel, calibratePanel, healthPanel];
