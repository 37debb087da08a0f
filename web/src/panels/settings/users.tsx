// The people who may sign in, for engineers.
import { useState } from 'preact/hooks';
import type { User } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { rest, wholeList, type Problem } from '../../link/rest';
import { t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';
import { roles, type Role } from './roles';

const nameMost = 32;
const displayMost = 64;
const passwordLeast = 12;
const passwordMost = 128;

export function UsersSection() {
  const users = useQuery(() => wholeList((query) => rest('GET /api/v1/users', { query })), []);
  const [open, setOpen] = useState<string | null>(null); // account being changed; '' = the new one
  const close = () => {
    setOpen(null);
    users.retry();
  };
  return (
    <section class="card">
      <h2>{t('settings.users')}</h2>
      <Trouble problem={users.problem} retry={users.retry} />
      <ul class="rows">
        {(users.value?.items ?? []).map((user) => (
          <li key={user.user} class={open === user.user ? 'wide' : undefined}>
            <div class="row-text">
              <strong>{user.display_name}</strong>
              <span>
                {user.user} · {t(`role.${user.role}`)}
                {user.enabled ? '' : ` · ${t('users.disabled')}`}
              </span>
            </div>
            {open === user.user ? (
              <Change user={user} close={close} />
            ) : (
              <div class="row-buttons">
                <button type="button" class="plain" aria-label={`${t('common.edit')}: ${user.display_name}`} onClick={() => setOpen(user.user)}>
                  {t('common.edit')}
                </button>
              </div>
            )}
          </li>
        ))}
      </ul>
      {open === '' ? (
        <New close={close} />
      ) : (
        <button type="button" class="plain" onClick={() => setOpen('')}>
          {t('users.new')}
        </button>
      )}
    </section>
  );
}

function RoleChoice({ role, choose }: { role: Role; choose: (role: Role) => void }) {
  return (
    <div class="field">
      <span>{t('users.role')}</span>
      <div class="choice" role="radiogroup" aria-label={t('users.role')}>
        {roles.map((one) => (
          <button key={one} type="button" role="radio" aria-checked={one === role} onClick={() => choose(one)}>
            {t(`role.${one}`)}
          </button>
        ))}
      </div>
      <span>{t(`users.may.${role}`)}</span>
    </div>
  );
}

function New({ close }: { close: () => void }) {
  const [name, setName] = useState('');
  const [display, setDisplay] = useState('');
  const [role, setRole] = useState<Role>('therapist');
  const [password, setPassword] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async () => {
    const body = { user: name.trim().toLowerCase(), display_name: display.trim(), role, password };
    const answer = await rest('POST /api/v1/users', { body });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    notify('info', t('users.added', { name: body.display_name }), true);
    close();
  };
  const missing = [
    ...(name.trim() === '' ? [t('signin.name')] : []),
    ...(display.trim() === '' ? [t('users.display')] : []),
    ...(password.length < passwordLeast ? [t('users.firstPassword')] : []),
  ];
  return (
    <Form label={t('users.new')} onSend={() => void save()}>
      <Field label={t('signin.name')} hint={t('users.nameHint')} value={name} most={nameMost} onValue={setName} />
      <Field label={t('users.display')} value={display} most={displayMost} onValue={setDisplay} />
      <RoleChoice role={role} choose={setRole} />
      <Field label={t('users.firstPassword')} hint={t('users.passwordHint')} value={password} most={passwordMost} onValue={setPassword} />
      <Trouble problem={problem} />
      <FormButtons missing={missing} close={close} />
    </Form>
  );
}

function Change({ user, close }: { user: User; close: () => void }) {
  const [display, setDisplay] = useState(user.display_name);
  const [role, setRole] = useState<Role>(user.role);
  const [enabled, setEnabled] = useState(user.enabled);
  const [password, setPassword] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async () => {
    const body = { display_name: display.trim(), role, enabled, ...(password === '' ? {} : { password }) };
    const answer = await rest('PATCH /api/v1/users/{name}', { path: { name: user.user }, body, etag: user.etag });
    setProblem(answer.ok ? null : answer.problem);
    if (answer.ok) close();
  };
  const missing = [
    ...(display.trim() === '' ? [t('users.display')] : []),
    ...(password !== '' && password.length < passwordLeast ? [t('users.reset')] : []),
  ];
  return (
    <Form label={user.display_name} onSend={() => void save()}>
      <Field label={t('users.display')} value={display} most={displayMost} onValue={setDisplay} />
      <RoleChoice role={role} choose={setRole} />
      <Field label={t('users.reset')} hint={t('users.resetHint')} value={password} most={passwordMost} onValue={setPassword} />
      <label class="check">
        <input type="checkbox" checked={enabled} onChange={(event) => setEnabled(event.currentTarget.checked)} />
        <span>{t('users.enabled')}</span>
      </label>
      <p class="hint">{t('users.changeHint')}</p>
      <Trouble problem={problem} />
      <FormButtons missing={missing} close={close} />
    </Form>
  );
}
