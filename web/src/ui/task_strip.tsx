// The chosen task on the screens where it is walked: which repetition, for how long, and how long the patient still rests.
import { chooseTask } from '../link/console';
import { useReading } from '../link/live';
import { useReadiness } from '../link/readiness';
import { useStore } from '../link/store';
import type { TaskState } from '../contract/rest.gen';
import { duration, t } from '../text/text';
import { tell } from './refusal';
import { useTaskTitles } from './task_titles';
import './task_strip.css';

const step_s = 0.01;

/** What there is to do now, at this step of the hoist. */
export function phaseOf(
  task: TaskState,
  tick: number,
  led: boolean,
): { key: 'task.ready' | 'task.broken' | 'task.under' | 'task.left' | 'task.resting' | 'task.next' | 'task.done'; seconds: number } {
  const since = (from: number) => Math.max(0, (tick - from) * step_s);
  if (task.begun_tick === null) return { key: 'task.ready', seconds: 0 };
  if (!task.reached && !led) return { key: 'task.broken', seconds: 0 };
  if (!task.reached) {
    const seconds = since(task.begun_tick);
    return task.ends === 'time' ? { key: 'task.left', seconds: Math.max(0, task.goal - seconds) } : { key: 'task.under', seconds };
  }
  if (task.repetition >= task.repetitions) return { key: 'task.done', seconds: 0 };
  // The rest begins when the hoist has come to standby; it has no beginning after a motion that was none of the task.
  const seconds = task.ended_tick !== null ? task.rest_s - since(task.ended_tick) : led ? task.rest_s : 0;
  return seconds > 0 ? { key: 'task.resting', seconds: Math.ceil(seconds) } : { key: 'task.next', seconds: 0 };
}

export function TaskStrip() {
  const task = useStore((s) => s.task);
  return task === null ? null : <Strip task={task} />;
}

function Strip({ task }: { task: TaskState }) {
  const { led, may } = useReadiness();
  const titleOf = useTaskTitles();
  const phase = useReading('state', (sample) => phaseOf(task, sample?.tick ?? 0, led));
  const leave = async () => {
    const refused = await chooseTask({ task: null });
    if (refused !== null) tell(refused);
  };
  return (
    <div class="task-strip">
      <strong>{task.line ?? titleOf(task.task)}</strong>
      <span>{t('task.repetition', { n: Math.max(1, task.repetition), of: task.repetitions })}</span>
      <span class="num" role="timer">
        {t(phase.key, { time: duration(phase.seconds) })}
      </span>
      {led ? (
        <span class="hint task-leave">{t('task.leaveLater')}</span>
      ) : (
        <button type="button" class="quiet task-leave" disabled={!may} onClick={() => void leave()}>
          {t('task.leave')}
        </button>
      )}
    </div>
  );
}
