// Signing in, the first set-up and signing out in a browser with the stand-in server. STOP is tried on each page.
import type { Page } from 'playwright-core';
import { describe, expect, it } from 'vitest';
import { de } from '../src/text/de';
import { en } from '../src/text/en';
import { first } from '../src/text/first';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const start = eachPage(1024, 768);
let fake: FakeServer;
let page: Page;

async function open(...how: Parameters<typeof start>) {
  ({ fake, page } = await start(...how));
  await page.goto(fake.url);
}
const button = (name: string) => page.getByRole('button', { name, exact: true });
const field = (label: string) => page.getByLabel(label, { exact: false }).first();
const stop = () => page.locator('.stop');

describe('signing in', { timeout: minutes_ms }, () => {
  it('with name and password opens the console; a wrong password says so and nothing else', async () => {
    await open({ signedIn: false, pins: false });
    await field(en['signin.name']).fill('Berg ');
    await field(en['signin.password']).fill('not that one');
    await button(en['signin.do']).click();
    await page.locator('.form-error').waitFor();
    expect(await field(en['signin.password']).inputValue(), 'a wrong password does not stay').toBe('');
    expect(await page.locator('.shell').count()).toBe(0);
    await field(en['signin.password']).fill('berg and valley 1');
    await button(en['signin.do']).click();
    await page.locator('.mode-standby').waitFor();
  });

  it('waits as long as the server says, counting down, and then works', async () => {
    await open({ signedIn: false, pins: false });
    await field(en['signin.name']).fill('berg');
    for (let tries = 0; tries < 3; tries++) {
      await field(en['signin.password']).fill('not that one');
      await button(en['signin.do']).click();
      await expect.poll(() => field(en['signin.password']).inputValue(), { timeout: 10_000 }).toBe('');
    }
    const waiting = page.getByRole('button', { name: en['signin.wait'].replace('{s}', '2') });
    await waiting.waitFor();
    expect(await waiting.isDisabled()).toBe(true);
    await field(en['signin.password']).fill('berg and valley 1');
    await expect.poll(() => button(en['signin.do']).isEnabled(), { timeout: 10_000 }).toBe(true);
    await button(en['signin.do']).click();
    await page.locator('.mode-standby').waitFor();
  });

  it('by PIN is one tap and four figures where the person is known', async () => {
    await open({ signedIn: false }, 'de');
    await button('Anna Berg').click();
    await field(de['signin.pin']).fill('1234');
    await page.keyboard.press('Enter');
    await page.locator('.mode-standby').waitFor();
  });

  it('after a wrong PIN says what is wrong, and the password form has the name', async () => {
    await open({ signedIn: false });
    await button('Anna Berg').click();
    await field(en['signin.pin']).fill('4711');
    await button(en['signin.do']).click();
    await page.locator('.form-error', { hasText: 'PIN' }).waitFor();
    await button(en['signin.byPassword']).click();
    expect(await field(en['signin.name']).inputValue()).toBe('berg');
    await field(en['signin.password']).fill('berg and valley 1');
    await button(en['signin.do']).click();
    await page.locator('.mode-standby').waitFor();
  });

  it('shows STOP on a device that was ever signed in, and on no other', async () => {
    await open({ signedIn: false });
    await page.locator('.sign-in-people').waitFor();
    expect(await stop().count()).toBe(0);
    await page.evaluate(() => localStorage.setItem('hoist.known', '1'));
    await page.reload();
    await page.locator('.sign-in-people').waitFor();
    await stop().dispatchEvent('pointerdown');
    await expect.poll(() => fake.hoist.mode, { timeout: 10_000 }).toBe('protective_stop');
  });

  it('is asked for again after signing out at standstill, without an alarm; STOP stays', async () => {
    await open();
    await page.locator('.mode-standby').waitFor();
    await page.goto(`${fake.url}#/settings/me`);
    await button(en['signin.out']).click();
    await page.locator('.sign-in-people').waitFor();
    expect(await page.locator('.settings').count(), 'nothing of the screen stays').toBe(0);
    await page.waitForTimeout(1500); // as long as an alarm about old values needs
    expect(await page.getByRole('alert').count()).toBe(0);
    await stop().dispatchEvent('pointerdown');
    await expect.poll(() => fake.hoist.mode, { timeout: 10_000 }).toBe('protective_stop');
    await button('Miha Kos').click();
    await field(en['signin.pin']).fill('1234');
    await button(en['signin.do']).click();
    await page.locator('.settings').waitFor();
  });

  it('signing out in the middle of a walk alarms, and STOP stays', async () => {
    await open();
    await page.goto(`${fake.url}#/walk`);
    await button(en['walk.start']).click();
    await page.locator('.mode-user').waitFor();
    await page.goto(`${fake.url}#/settings/me`);
    await button(en['signin.out']).click();
    await page.getByRole('alert').getByText(en['strip.signedOut']).waitFor();
    await stop().dispatchEvent('pointerdown');
    await expect.poll(() => fake.hoist.mode, { timeout: 10_000 }).toBe('protective_stop');
  });
});

describe('the first set-up', { timeout: minutes_ms }, () => {
  const fill = async (code: string) => {
    await field(en['setup.codeField']).fill(code);
    await field(en['signin.name']).fill('kos2');
    await field(en['users.display']).fill('Miha Kos');
    await page.getByLabel(en['signin.password']).first().fill('long enough now');
    await page.getByLabel(en['users.again']).fill('long enough now');
  };

  it('needs the switch: without it the button is off and the page says so', async () => {
    await open({ signedIn: false, set_up: { needed: true, switch_on: false, seconds_left: 0 } });
    await page.getByText(en['setup.off']).waitFor();
    await fill('12345678');
    expect(await button(en['setup.do']).isDisabled()).toBe(true);
  });

  it('leaves the way to the accounts that exist before an engineer has one, and back', async () => {
    await open({ signedIn: false, set_up: { needed: true, switch_on: false, seconds_left: 0 } });
    await button(en['signin.do']).click();
    await button(en['setup.title']).click();
    await field(en['setup.codeField']).waitFor();
    await button(en['signin.do']).click();
    await button('Anna Berg').click();
    await field(en['signin.pin']).fill('1234');
    await page.keyboard.press('Enter');
    await page.locator('.mode-standby').waitFor();
  });

  it('refuses a wrong code and keeps what was typed; the right one makes the account and signs in', async () => {
    await open({ signedIn: false, set_up: { needed: true, switch_on: true, seconds_left: 500 } });
    await fill('00000000');
    await button(en['setup.do']).click();
    await page.locator('.form-error').waitFor();
    expect(await field(en['users.display']).inputValue()).toBe('Miha Kos');
    await field(en['setup.codeField']).fill('12345678');
    await button(en['setup.do']).click();
    await page.locator('.mode-standby').waitFor();
  });

  it('does not take two passwords that differ', async () => {
    await open({ signedIn: false, set_up: { needed: true, switch_on: true, seconds_left: 500 } });
    await fill('12345678');
    await page.getByLabel(en['users.again']).fill('long enough not');
    await page.getByText(en['users.differ']).waitFor();
    expect(await button(en['setup.do']).isDisabled()).toBe(true);
  });
});

describe('without a word loaded', { timeout: minutes_ms }, () => {
  it('STOP still acts when the page for signing in cannot be loaded', async () => {
    await open({ signedIn: false });
    await page.evaluate(() => localStorage.setItem('hoist.known', '1'));
    await page.route(/\/assets\/sign_in-/, (route) => route.fulfill({ status: 404, body: '' }));
    await page.reload();
    await page.getByText(first.en['load.failed']).waitFor();
    await stop().dispatchEvent('pointerdown');
    await expect.poll(() => fake.hoist.mode, { timeout: 10_000 }).toBe('protective_stop');
  });
});
