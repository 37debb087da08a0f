// Signing in: with name and password, or with a PIN on a device that the person has signed in on before; and the first set-up.
import { useEffect, useState } from 'preact/hooks';
import type { WhoAmI } from '../../contract/rest.gen';
import { signIn } from '../../link/account';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { useSettings } from '../../text/settings';
import { offerLanguage, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { LanguageChoice } from '../../ui/language_choice';
import { nameMost, passwordMost, Send, useSending } from './send';
import { SetUp } from './set_up';
import '../../ui/rows.css';
import './sign_in.css';

const pinMost = 8;
/** How often to look whether the set-up switch was turned, or the first account was made on another device. */
const look_ms = 3000;

type Person = WhoAmI['here'][number];

export function SignInView({ done }: { done?: () => void }) {
  useSettings();
  const [chosen, setChosen] = useState<'set up' | 'sign in' | null>(null);
  const who = useQuery(() => rest('GET /api/v1/session'), [], look_ms);
  const state = who.value;
  // Accounts may exist before an engineer's: the computer's own link makes them.
  const first = state?.set_up.needed === true;
  const settable = state?.problem === null && (first || state.set_up.switch_on);
  const settingUp = settable && (chosen === null ? first : chosen === 'set up');
  useEffect(() => offerLanguage(state?.device.language ?? null), [state?.device.language]);
  return (
    <div class="sign-in card">
      {state === null ? (
        <>
          <h1>{t('signin.title')}</h1>
          {who.problem === null ? <p class="hint">{t('common.loading')}</p> : null}
          <Trouble problem={who.problem} retry={who.retry} />
        </>
      ) : state.problem !== null ? (
        <>
          <h1>{t('signin.title')}</h1>
          <p class="form-error" role="alert">
            {t('signin.broken')}
          </p>
          <p class="hint">{state.problem}</p>
        </>
      ) : settingUp ? (
        <SetUp first={first} set_up={state.set_up} />
      ) : (
        <Who people={state.here} done={done} />
      )}
      {settable ? (
        <button type="button" class="quiet" onClick={() => setChosen(settingUp ? 'sign in' : 'set up')}>
          {t(settingUp ? 'signin.do' : first ? 'setup.title' : 'setup.lost')}
        </button>
      ) : null}
      <LanguageChoice />
      {state === null ? null : <p class="hint">{state.device.name}</p>}
    </div>
  );
}

function Who({ people, done }: { people: readonly Person[]; done?: () => void }) {
  const [person, setPerson] = useState<Person | null>(null);
  const [byName, setByName] = useState<string | null>(null);
  const ready = (problem: Problem | null) => {
    if (problem === null) done?.();
    return problem;
  };
  if (person !== null)
    return (
      <Pin
        person={person}
        ready={ready}
        back={() => setPerson(null)}
        toPassword={() => {
          setPerson(null);
          setByName(person.user);
        }}
      />
    );
  if (byName !== null || people.length === 0)
    return <Password user={byName ?? ''} ready={ready} back={people.length === 0 ? null : () => setByName(null)} />;
  return (
    <>
      <h1>{t('signin.who')}</h1>
      <ul class="sign-in-people">
        {people.map((one) => (
          <li key={one.user}>
            <button type="button" class="big" onClick={() => setPerson(one)}>
              {one.display_name}
            </button>
          </li>
        ))}
      </ul>
      <button type="button" class="quiet" onClick={() => setByName('')}>
        {t('signin.other')}
      </button>
    </>
  );
}

function Password({ user, ready, back }: { user: string; ready: (problem: Problem | null) => Problem | null; back: (() => void) | null }) {
  const [name, setName] = useState(user);
  const [password, setPassword] = useState('');
  const sending = useSending(async () => {
    const problem = ready(await signIn({ user: name.trim().toLowerCase(), password }));
    setPassword('');
    return problem;
  });
  return (
    <>
      <h1>{t('signin.title')}</h1>
      <Form label={t('signin.title')} onSend={() => void sending.go()}>
        <Field label={t('signin.name')} value={name} most={nameMost} fill="username" onValue={setName} />
        <Field label={t('signin.password')} type="password" value={password} most={passwordMost} fill="current-password" onValue={setPassword} />
        <Send sending={sending} label={t('signin.do')} ready={name.trim() !== '' && password !== ''} back={back} />
      </Form>
    </>
  );
}

function Pin({
  person,
  ready,
  back,
  toPassword,
}: {
  person: Person;
  ready: (problem: Problem | null) => Problem | null;
  back: () => void;
  toPassword: () => void;
}) {
  const [pin, setPin] = useState('');
  const sending = useSending(async () => {
    const problem = ready(await signIn({ user: person.user, pin }));
    setPin('');
    return problem;
  });
  return (
    <>
      <h1>{person.display_name}</h1>
      <Form label={t('signin.title')} onSend={() => void sending.go()}>
        <Field label={t('signin.pin')} type="password" value={pin} most={pinMost} numeric focus onValue={setPin} />
        <Send sending={sending} label={t('signin.do')} ready={pin.length >= 4} back={back} />
        <button type="button" class="quiet" onClick={toPassword}>
          {t('signin.byPassword')}
        </button>
      </Form>
    </>
  );
}
