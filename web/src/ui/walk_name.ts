// What a recorded walk is called.
import type { Session } from '../contract/rest.gen';
import { exerciseTitle } from '../text/exercise';
import { fixed } from '../text/text';

/** What was walked: the own line or the task with its repetition, else the exercise. */
export function walkName({ exercise, task }: Pick<Session, 'exercise' | 'task'>, titleOf: (task: string) => string): string {
  if (task !== null) return `${task.line ?? titleOf(task.task)}, ${fixed(task.repetition, 0)}/${fixed(task.repetitions, 0)}`;
  return exerciseTitle(exercise === null ? 'free' : exercise.shape);
}
