// Copies of the recordings: made, and put back.
import { useEffect, useState } from 'preact/hooks';
import type { Backup, BackupsResult, Job } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { useJob } from '../../link/jobs';
import { useQuery } from '../../link/query';
import { rest } from '../../link/rest';
import { useStore } from '../../link/store';
import { date, plain, t } from '../../text/text';
import { Trouble } from '../../ui/field';
import { HoldButton } from '../../ui/hold_button';
import { Progress } from '../../ui/progress';

const confirmHold_ms = 2000;
const giga = 1e9;
const mega = 1e6;
/** A size for people: 1.2 GB, 34 MB. */
export const size = (bytes: number): string => (bytes >= giga ? `${plain(bytes / giga)} GB` : `${plain(Math.max(0.1, bytes / mega))} MB`);

const listOf = (job: Job | null): BackupsResult | null => (job?.result?.kind === 'list_backups' ? job.result : null);

export function BackupSection() {
  const recording = useStore((s) => s.recording.state === 'recording' && !s.recording.standby);
  const [folder, setFolder] = useState<string | null>(null);
  const [names, setNames] = useState(false);
  const [known, setKnown] = useState<BackupsResult | null>(null);
  const list = useJob('list_backups', (job) => setKnown(listOf(job)));
  const look = () => void list.start({ kind: 'list_backups' });
  useEffect(look, []);
  const make = useJob('backup', () => {
    notify('info', 'backup.made');
    look();
  });
  const restore = useJob('restore', () => {
    notify('info', 'backup.restored');
    look();
  });
  const here = useQuery(() => rest('GET /api/v1/settings'), []).value?.hoist_id ?? null;
  const busy = make.busy || restore.busy;
  const folders = known?.folders.filter((one) => one.there) ?? [];
  const target = folders.find((one) => one.folder === folder) ?? folders[0];
  return (
    <>
      <section class="card">
        <h2>{t('backup.make')}</h2>
        <p class="hint">{t('backup.makeHint')}</p>
        {known !== null && folders.length === 0 ? <p class="hint">{t('backup.nowhere')}</p> : null}
        {folders.length > 0 ? (
          <label class="field">
            <span>{t('backup.where')}</span>
            <select value={target?.folder} disabled={busy} onChange={(event) => setFolder(event.currentTarget.value)}>
              {folders.map((one) => (
                <option key={one.folder} value={one.folder}>
                  {one.folder}
                  {one.free_bytes === null ? '' : ` (${t('backup.free', { size: size(one.free_bytes) })})`}
                </option>
              ))}
            </select>
          </label>
        ) : null}
        <label class="check">
          <input type="checkbox" checked={names} disabled={busy} onChange={(event) => setNames(event.currentTarget.checked)} />
          <span>{t('backup.names')}</span>
        </label>
        <div class="form-buttons">
          <button
            type="button"
            class="big primary"
            disabled={busy || target === undefined}
            onClick={() => void make.start({ kind: 'backup', ...(target ? { folder: target.folder } : {}), identity_key: names })}
          >
            {t('backup.now')}
          </button>
          <button type="button" class="plain" disabled={list.busy || busy} onClick={look}>
            {t('backup.look')}
          </button>
        </div>
        <Progress work={make} label={t('backup.making')} />
        <Trouble problem={make.problem ?? list.problem} />
      </section>
      <section class="card">
        <h2>{t('backup.all')}</h2>
        <p class="hint">{t(recording ? 'backup.notNow' : 'backup.restoreHint')}</p>
        <Progress work={restore} label={t('backup.restoring')} />
        <Trouble problem={restore.problem} />
        {known === null ? <p class="hint">{t('common.loading')}</p> : null}
        {known !== null && known.items.length === 0 ? <p class="hint">{t('backup.none')}</p> : null}
        <ul class="rows">
          {(known?.items ?? []).map((item) => (
            <BackupRow
              key={item.backup}
              item={item}
              foreign={here !== null && item.hoist_id !== null && item.hoist_id !== here}
              may={!busy && !recording}
              restore={() => void restore.start({ kind: 'restore', backup: item.backup })}
            />
          ))}
        </ul>
      </section>
    </>
  );
}

interface RowProps {
  item: Backup;
  /** Of another hoist. */
  foreign: boolean;
  may: boolean;
  restore: () => void;
}

function BackupRow({ item, foreign, may, restore }: RowProps) {
  const [asked, setAsked] = useState(false);
  const bytes = item.files.reduce((sum, file) => sum + file.bytes, 0);
  return (
    <li class="wide">
      <div class="row-text">
        <strong>{date(item.utc_ms)}</strong>
        <span>{t('backup.holds', { device: item.device, n: item.sessions, size: size(bytes) })}</span>
        <span class="settings-path">{item.backup}</span>
        {foreign ? <span class="backup-foreign">{t('backup.foreign')}</span> : null}
      </div>
      <div class="row-buttons">
        {asked ? (
          <>
            <HoldButton
              label={t('backup.hold')}
              hint={t('backup.holdHint')}
              hold_ms={confirmHold_ms}
              disabled={!may}
              onDone={() => {
                setAsked(false);
                restore();
              }}
            />
            <button type="button" class="quiet" onClick={() => setAsked(false)}>
              {t('common.cancel')}
            </button>
          </>
        ) : (
          <button type="button" class="plain" disabled={!may} onClick={() => setAsked(true)}>
            {t('backup.restore')}
          </button>
        )}
      </div>
    </li>
  );
}
