// This hoist: its name and language, the addresses under which it is reached, how a device comes to trust it, its clock.
import { Fragment } from 'preact';
import { useState } from 'preact/hooks';
import type { DeviceSettings } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { languages } from '../../text/settings';
import { date, fixed, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { may } from './roles';

const nameMost = 64;
/** Clocks that differ by less are right enough for dates of walks. */
const right_s = 2;

export function DeviceSection() {
  const role = useStore((s) => s.role);
  const settings = useQuery(() => rest('GET /api/v1/settings'), []);
  const now = settings.value;
  return (
    <>
      <section class="card">
        <h2>{t('settings.device')}</h2>
        <Trouble problem={settings.problem} retry={settings.retry} />
        {now === null ? null : may(role, 'engineer') ? (
          <NameForm key={now.etag} settings={now} onChange={settings.retry} />
        ) : (
          <p>{now.device_name === '' ? now.computer_name : now.device_name}</p>
        )}
        {now === null ? null : (
          <dl class="settings-known">
            <dt>{t('device.id')}</dt>
            <dd>
              <code>{now.hoist_id}</code>
            </dd>
          </dl>
        )}
      </section>
      <NetworkCard />
      <ClockCard />
    </>
  );
}

function NameForm({ settings, onChange }: { settings: DeviceSettings; onChange: () => void }) {
  const [name, setName] = useState(settings.device_name);
  const [language, setLanguage] = useState(settings.language ?? '');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async () => {
    const chosen = languages.find(({ id }) => id === language)?.id ?? null;
    const body = { device_name: name.trim(), language: chosen };
    const answer = await rest('PATCH /api/v1/settings', { body, etag: settings.etag });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    notify('info', 'sessions.saved');
    onChange();
  };
  return (
    <Form onSend={() => void save()} label={t('settings.device')}>
      <Field label={t('device.name')} hint={t('device.nameHint', { name: settings.computer_name })} value={name} most={nameMost} onValue={setName} />
      <label class="field">
        <span>
          {t('bar.language')}
          <small> · {t('device.languageHint')}</small>
        </span>
        <select value={language} onChange={(event) => setLanguage(event.currentTarget.value)}>
          <option value="">{t('device.languageOpen')}</option>
          {languages.map((one) => (
            <option key={one.id} value={one.id}>
              {one.name}
            </option>
          ))}
        </select>
      </label>
      <Trouble problem={problem} />
      <button type="submit" class="plain" disabled={name.trim() === settings.device_name && language === (settings.language ?? '')}>
        {t('common.save')}
      </button>
    </Form>
  );
}

function NetworkCard() {
  const network = useQuery(() => rest('GET /api/v1/network'), []);
  const now = network.value;
  return (
    <section class="card">
      <h2>{t('device.network')}</h2>
      <Trouble problem={network.problem} retry={network.retry} />
      {now === null ? null : (
        <>
          <dl class="settings-known">
            {now.interfaces
              .filter(({ loopback, addresses }) => !loopback && addresses.length > 0)
              .map(({ name, up, addresses }) => (
                <Fragment key={name}>
                  <dt>
                    {name}
                    {up ? '' : ` · ${t('device.unplugged')}`}
                  </dt>
                  <dd>{addresses.join(', ')}</dd>
                </Fragment>
              ))}
            <dt>{t('device.names')}</dt>
            <dd>{now.tls.names.length === 0 ? now.computer_name : now.tls.names.join(', ')}</dd>
            {now.tls.fingerprint === null ? null : (
              <>
                <dt>{t('device.fingerprint')}</dt>
                <dd>
                  <code>{now.tls.fingerprint}</code>
                </dd>
              </>
            )}
          </dl>
          {now.tls.trust_page === null ? (
            <p class="hint">{t(now.tls.on ? 'device.ownCertificate' : 'device.noTls')}</p>
          ) : (
            <a class="plain" href={now.tls.trust_page}>
              {t('device.trust')}
            </a>
          )}
        </>
      )}
    </section>
  );
}

function ClockCard() {
  const time = useQuery(() => rest('GET /api/v1/time', { query: { client_utc_ms: Date.now() } }), []);
  const now = time.value;
  const behind_s = now?.client_behind_s ?? null;
  return (
    <section class="card">
      <h2>{t('device.clock')}</h2>
      <Trouble problem={time.problem} retry={time.retry} />
      {now === null ? null : (
        <>
          <p class="num">{date(now.utc_ms)}</p>
          {behind_s !== null && Math.abs(behind_s) >= right_s ? (
            <p>{t(behind_s > 0 ? 'device.hereBehind' : 'device.hereAhead', { s: fixed(Math.abs(behind_s), 0) })}</p>
          ) : (
            <p class="hint">{t('device.clockAgrees')}</p>
          )}
          <p class="hint">
            {now.synchronised === true ? t('device.synchronised') : t('device.unsynchronised')}
            {now.kept_by === 'operating_system' ? ` ${t('device.clockSystem')}` : ''}
          </p>
        </>
      )}
    </section>
  );
}
