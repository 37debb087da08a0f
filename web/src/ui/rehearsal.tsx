// What staff did in a rehearsal on the simulated hoist: one sentence each, with its time.
import type { RehearsalCheck, RehearsalItem, RehearsalKind, RehearsalResult } from '../contract/rest.gen';
import { told, type SeldomText } from '../text/seldom';
import { fixed } from '../text/text';
import './rehearsal.css';

export const rehearsals: Readonly<Record<RehearsalKind, { title: SeldomText; what: SeldomText }>> = {
  trip: { title: 'trip', what: 'tripWhat' },
  freeze: { title: 'freeze', what: 'freezeWhat' },
  bumper: { title: 'bumper', what: 'bumperWhat' },
  link_loss: { title: 'link', what: 'linkWhat' },
  low_battery: { title: 'battery', what: 'batteryWhat' },
  second_therapist: { title: 'second', what: 'secondWhat' },
};
export const rehearsalTitle = (kind: RehearsalKind): string => told(rehearsals[kind].title);

const sentences: Readonly<Record<RehearsalCheck, Readonly<Record<RehearsalItem['seen'], SeldomText>>>> = {
  stop: { good: 'stopGood', wrong: 'stopWrong', missing: 'stopMissing' },
  look: { good: 'lookGood', wrong: 'lookWrong', missing: 'notReleased' },
  cause_gone: { good: 'causeGood', wrong: 'causeWrong', missing: 'notReleased' },
  acknowledge: { good: 'releaseGood', wrong: 'releaseWrong', missing: 'releaseMissing' },
  zero: { good: 'zeroGood', wrong: 'zeroWrong', missing: 'zeroMissing' },
  go_on: { good: 'goGood', wrong: 'goWrong', missing: 'goMissing' },
  regain: { good: 'regainGood', wrong: 'regainWrong', missing: 'regainMissing' },
  end: { good: 'endGood', wrong: 'endWrong', missing: 'endMissing' },
  stay_ended: { good: 'stayGood', wrong: 'stayWrong', missing: 'notEnded' },
  answer: { good: 'answerGood', wrong: 'answerWrong', missing: 'answerMissing' },
  standing: { good: 'standingGood', wrong: 'standingWrong', missing: 'notAnswered' },
};
const marks = { good: '✓', wrong: '✗', missing: '–' } as const;
const markTexts = { good: 'good', wrong: 'wrong', missing: 'missing' } as const satisfies Record<string, SeldomText>;

export const rehearsalSentence = ({ check, seen, after_s, limit_s }: RehearsalItem): string =>
  told(sentences[check][seen], { s: fixed(after_s, 1), limit: fixed(limit_s, 0) });

export function RehearsalItems({ result }: { result: RehearsalResult }) {
  return (
    <ul class="rehearsal-items">
      {result.items.map((item) => (
        <li key={item.check} class={item.seen}>
          <span class="rehearsal-mark" role="img" aria-label={told(markTexts[item.seen])}>
            {marks[item.seen]}
          </span>
          <span>{rehearsalSentence(item)}</span>
        </li>
      ))}
    </ul>
  );
}
