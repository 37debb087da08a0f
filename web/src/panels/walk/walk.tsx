// The patient leads: choose the exercise, start, watch, mark, end.
import { useEffect } from 'preact/hooks';
import { chooseExercise, marker, notify, requestMode, setNeutral } from '../../link/console';
import { live, useReading } from '../../link/live';
import { usualExercise } from '../../contract/exercises.gen';
import type { MarkerKind } from '../../contract/rest.gen';
import { useReadiness } from '../../link/readiness';
import { figure, useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { exerciseTitle } from '../../text/exercise';
import { degrees, duration, fixed, t } from '../../text/text';
import { FloorView } from '../../ui/floor_view';
import { HoistPicture } from '../../ui/hoist_picture';
import { Reading } from '../../ui/reading';
import { Refusal, StartBlockers, useRequest } from '../../ui/refusal';
import { StartEnd } from '../../ui/start_end';
import { TaskStrip } from '../../ui/task_strip';
import './walk.css';

/** The server's default for its scenario comes first. */
const choices = [usualExercise.eight, usualExercise.square, usualExercise.straight, usualExercise.free];
const markers: readonly MarkerKind[] = ['help', 'stumble', 'rest', 'good'];

export function WalkView() {
  useSettings();
  const { led, may, standby } = useReadiness();
  const exercise = useStore((s) => s.exercise);
  const drawn = useStore(figure);
  const request = useRequest();
  // Marks and the neutral posture wait for their answers separately: a slow one must not block End.
  const aside = useRequest();
  useEffect(() => {
    if (!led) return;
    request.forget();
    aside.forget();
  }, [led]);

  const mark = async (kind: MarkerKind) => {
    const text = t(`marker.${kind}`);
    if (await aside.ask(() => marker(text, kind))) notify('info', t('walk.marked', { text }), true);
  };
  const neutral = async () => {
    if (await aside.ask(setNeutral)) notify('info', t('walk.neutralDone'), true);
  };

  return (
    <div class="walk">
      <div class="walk-controls">
        <div class="choice" role="radiogroup" aria-label={t('exercise.label')}>
          {choices.map((choice) => {
            const chosen = choice.shape === exercise.shape;
            return (
              <button
                key={choice.shape}
                type="button"
                role="radio"
                aria-checked={chosen}
                disabled={led || !may}
                // Not the chosen one again: that would end its task and take away its size.
                onClick={() => (chosen ? undefined : void aside.ask(() => chooseExercise(choice)))}
              >
                {exerciseTitle(choice.shape)}
              </button>
            );
          })}
        </div>
        <button
          type="button"
          class="plain two-lines"
          disabled={request.busy || aside.busy || !standby || !may}
          title={t('walk.neutralHint')}
          onClick={() => void neutral()}
        >
          {t('walk.neutral')} <small>{t('walk.neutralShort')}</small>
        </button>
        <StartEnd
          request={request}
          of="user"
          startLabel={t('walk.start')}
          endLabel={t('walk.end')}
          wait={aside.busy}
          start={(again) => requestMode('user', exercise, again)}
        />
      </div>
      <Refusal request={request} />
      <Refusal request={aside} />
      <StartBlockers request={request} of="user" />
      <TaskStrip />
      <div class="walk-body">
        <section class="card floor-card">
          <FloorView exercise={drawn} />
        </section>
        <section class="card">
          <HoistPicture />
          <div class="readings">
            <Reading label={t('walk.speed')} unit="m/s" topic="motion" read={(r) => fixed(r.speed_m_s, 2)} />
            <Reading label={t('walk.distance')} unit="m" topic="motion" read={(r) => fixed(live.walked_m(r), 1)} />
            <Time />
            <Reading label={t('walk.lean')} topic="posture" read={(r) => degrees((r.left_alpha_rad + r.right_alpha_rad) / 2 - r.base_alpha_rad)} />
            <Reading label={t('walk.turn')} unit="°/s" topic="motion" read={(r) => fixed((r.yaw_rate_rad_s * 180) / Math.PI, 0)} />
            <Reading label={t('walk.stopDistance')} unit="cm" topic="motion" read={(r) => fixed(Math.ceil(r.stop_distance_m * 100), 0)} />
          </div>
          <div class="markers" role="group" aria-label={t('walk.markers')}>
            {markers.map((kind) => (
              <button key={kind} type="button" class="plain" disabled={!may || !led} onClick={() => void mark(kind)}>
                {t(`marker.${kind}`)}
              </button>
            ))}
          </div>
        </section>
      </div>
    </div>
  );
}

function Time() {
  const text = useReading('state', () => duration(live.motion_s));
  return (
    <div class="reading">
      <span class="reading-label">{t('walk.time')}</span>
      <span class="reading-value">
        <span class="num">{text}</span>
      </span>
    </div>
  );
}
