// Made by `deploy/dev gen` from control/contract/commands.hpp and can_dictionary.def; do not edit.

/** What the core reports, by the number it has on the wire. */
export const eventKinds = [
  'none',
  'command_done',
  'command_refused',
  'mode_changed',
  'fault_raised',
  'fault_cleared',
  'parameter_changed',
  'lease_changed',
  'node_changed',
  'pose_set',
  'neutral_set',
  'core_started',
] as const;
export type EventKind = (typeof eventKinds)[number];

export type NodeName =
  | 'drive_left'
  | 'drive_right'
  | 'io'
  | 'tilt_left'
  | 'tilt_right'
  | 'tilt_base'
  | 'core';

export interface NodeInfo {
  name: NodeName;
  id: number;
  title: string;
}

/** The nodes of the bus, in the order of their numbers in events. */
export const nodes: readonly NodeInfo[] = [
  { name: 'drive_left', id: 1, title: 'Left drive' },
  { name: 'drive_right', id: 2, title: 'Right drive' },
  { name: 'io', id: 8, title: 'Bumpers and batteries' },
  { name: 'tilt_left', id: 17, title: 'Left strut sensor' },
  { name: 'tilt_right', id: 18, title: 'Right strut sensor' },
  { name: 'tilt_base', id: 19, title: 'Chassis sensor' },
  { name: 'core', id: 127, title: 'Control computer' },
];

/** Two programs with different hashes do not understand each other. */
export const layoutHash = '86b9d280b235a491';
