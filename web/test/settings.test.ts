// Long work in a browser with the stand-in server: what a press does, and what is told when it does not work.
import type { Page } from 'playwright-core';
import { beforeEach, describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const start = eachPage(1280, 800);
let fake: FakeServer;
let page: Page;
beforeEach(async () => {
  ({ fake, page } = await start({ jobs_ms: minutes_ms }));
});

const open = (hash: string) => page.goto(`${fake.url}#/${hash}`);
const button = (name: string) => page.getByRole('button', { name, exact: true });

describe('backup', { timeout: minutes_ms }, () => {
  it('is made with progress, and then stands first in the list', async () => {
    await open('settings/backup');
    await page.locator('.settings-part .rows li').waitFor();
    await button(en['backup.now']).click();
    await page.locator('progress').waitFor();
    expect(await button(en['backup.now']).isDisabled(), 'not twice at once').toBe(true);
    fake.finishJobs();
    await page.getByText(en['backup.made']).waitFor();
    await expect.poll(() => page.locator('.settings-part .rows li').count(), { timeout: 10_000 }).toBe(2);
    expect(await page.locator('.settings-part .rows li').first().textContent()).toContain('/media/usb/');
    expect(await page.locator('progress').count()).toBe(0);
  });

  it('goes on when the screen is left, and is shown again', async () => {
    await open('settings/backup');
    await button(en['backup.now']).click();
    await page.locator('progress').waitFor();
    await open('tune');
    await page.locator('.tune-row').first().waitFor();
    await open('settings/backup');
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await expect.poll(() => page.locator('.settings-part .rows li').count(), { timeout: 10_000 }).toBe(2);
  });

  it('is put back only by holding, and says why a place has none', async () => {
    await open('settings/backup');
    await button(en['backup.restore']).click();
    await button(en['backup.hold']).click();
    expect(
      fake.jobs.filter(({ kind }) => kind === 'restore'),
      'a tap is not enough',
    ).toEqual([]);
    await button(en['backup.hold']).click({ delay: 2200 });
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await page.getByText(en['backup.restored']).waitFor();
    expect(fake.jobs.filter(({ kind }) => kind === 'restore')).toHaveLength(1);
  });

  it('that fails says the reason of the table', async () => {
    fake.failNext('backup', 'disk_full');
    await open('settings/backup');
    await button(en['backup.now']).click();
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await page.getByText('The storage is full.').waitFor();
    expect(await button(en['backup.now']).isEnabled()).toBe(true);
  });
});

describe('keeping recordings', { timeout: minutes_ms }, () => {
  it('saves a rule only after showing what it deletes, and deletes only by holding', async () => {
    await open('settings/retention');
    await page.getByText(en['retention.off']).waitFor();
    expect(await button(en['retention.preview']).isDisabled(), 'nothing is chosen').toBe(true);
    await page.getByLabel(en['retention.days']).check();
    await page.getByRole('textbox', { name: en['retention.daysNumber'] }).fill('180');
    expect(await button(en['common.save']).isDisabled(), 'not seen yet').toBe(true);
    await button(en['retention.preview']).click();
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await page.getByText('Recordings to delete: 37', { exact: false }).waitFor();
    await page.getByText('Kept because no backup holds them: 12').waitFor();
    const rule = { days: 180, disk_percent: null, needs_backup: true };
    expect(fake.jobs.at(-1)).toMatchObject({ kind: 'preview_retention', asked: { rule } });
    expect(await button(en['retention.hold']).count(), 'the rule is not stored').toBe(0);
    await page.getByRole('textbox', { name: en['retention.daysNumber'] }).fill('90');
    expect(await button(en['common.save']).isDisabled(), 'another rule than the one that was shown').toBe(true);
    await page.getByRole('textbox', { name: en['retention.daysNumber'] }).fill('180');
    await button(en['common.save']).click();
    await page.getByText(en['retention.on']).waitFor();
    await button(en['retention.hold']).click();
    expect(fake.jobs.filter(({ kind }) => kind === 'retention')).toEqual([]);
    await button(en['retention.hold']).click({ delay: 2200 });
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await page.getByText('Deleted recordings: 37').waitFor();
  });
});

describe('many sessions as one file', { timeout: minutes_ms }, () => {
  it('are asked for by day and patient, and downloaded when the file is made', async () => {
    await open('sessions');
    await page.getByLabel(en['exports.from']).fill('2026-11-01');
    await page.getByLabel(en['sessions.subject']).last().fill(' K-07 ');
    await page.getByLabel(en['exports.layout']).selectOption('bids');
    await button(en['exports.make']).click();
    await page.locator('progress').waitFor();
    expect(await button(en['exports.make']).isDisabled()).toBe(true);
    expect(await page.locator('.session-none a[download]').count(), 'nothing to download before it is made').toBe(0);
    fake.finishJobs();
    await page.locator('.session-none a[download]').waitFor();
    expect(await page.locator('.session-none a[download]').getAttribute('href')).toMatch(/\/api\/v1\/jobs\/\d+\/file$/);
    expect(fake.jobs.at(-1)).toMatchObject({
      kind: 'export_sessions',
      asked: { layout: 'bids', simulated: false, from_day: '2026-11-01', subject: 'K-07' },
    });
    expect(Object.keys(fake.jobs.at(-1)?.asked ?? {}), 'an empty field is no filter').not.toContain('to_day');
    await page.getByLabel(en['exports.layout']).selectOption('patient');
    await button(en['exports.make']).click();
    await page.locator('progress').waitFor();
    expect(fake.jobs.at(-1)).toMatchObject({ asked: { layout: 'reports', report: 'patient', language: 'en' } });
    fake.finishJobs();
    await page.locator('.session-none a[download]').waitFor();
    fake.failNext('export_sessions', 'none_fits');
    await button(en['exports.make']).click();
    await page.locator('progress').waitFor();
    fake.finishJobs();
    await page.getByText('No session fits. Choose other days or another patient').waitFor();
  });
});

describe('signing out', { timeout: minutes_ms }, () => {
  it('that does not work says so', async () => {
    await open('settings/me');
    await button(en['signin.out']).waitFor();
    await fake.close();
    await button(en['signin.out']).click();
    await page.locator('.settings-part .form-error', { hasText: en['refused.link_lost'] }).waitFor();
  });
});

describe('a new token', { timeout: minutes_ms }, () => {
  it('is made once by a double tap', async () => {
    await open('settings/tokens');
    await page.locator('.settings-part .rows li').waitFor();
    let asked = 0;
    await page.route('**/api/v1/tokens', async (route) => {
      if (route.request().method() === 'POST') asked++;
      await route.continue();
    });
    await button(en['tokens.new']).click();
    await page.getByLabel(en['tokens.name']).fill('Gait lab');
    await button(en['common.save']).dblclick();
    await page.locator('.settings-secret').waitFor();
    expect(asked).toBe(1);
  });
});
