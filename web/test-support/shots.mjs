// Screenshots of every screen with the fake server: node test-support/shots.mjs OUT_FOLDER [size …]
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { startFakeServer } from './fake_server.mjs';
import { browserProgram } from './headless.mjs';

const out = process.argv[2];
const sizes = { '1280x800': [1280, 800], '1024x768': [1024, 768], '390x844': [390, 844] };
const wanted = process.argv.slice(3);
mkdirSync(out, { recursive: true });
const browser = await chromium.launch({
  executablePath: browserProgram,
  args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
for (const [size, [width, height]] of Object.entries(sizes)) {
  if (wanted.length > 0 && !wanted.includes(size)) continue;
  for (const { look, language } of [
    { look: 'light', language: 'en' },
    { look: 'dark', language: 'de' },
  ]) {
    const fake = await startFakeServer();
    const page = await browser.newPage({ viewport: { width, height }, colorScheme: look, locale: language });
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && console.log(`[${size} ${look}] ${message.text()}`));
    page.on('pageerror', (error) => console.log(`[${size} ${look}] ${error.stack}`));
    const shot = (name) => page.screenshot({ path: join(out, `${size}-${look}-${name}.png`) });
    await page.goto(fake.url);
    await page.waitForFunction(() => document.querySelector('.mode strong')?.textContent !== 'Starting');
    await page.waitForTimeout(600);
    await shot('home');
    await page.goto(`${fake.url}#/walk`);
    await page.waitForTimeout(300);
    await shot('walk-idle');
    await page.click('.walk-controls .primary');
    await page.waitForTimeout(300);
    fake.skip(1900);
    await page.waitForTimeout(900);
    await shot('walk-moving');
    await page.click('.walk-controls .big');
    await page.waitForTimeout(1500);
    await page.goto(`${fake.url}#/drive`);
    await page.waitForTimeout(300);
    await shot('drive-idle');
    await page.click('.walk-controls .primary');
    await page.waitForTimeout(400);
    const box = await page.locator('.pad').boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + box.height * 0.25);
    await page.waitForTimeout(1500);
    await shot('drive-held');
    await page.mouse.up();
    await page.locator('.stop').dispatchEvent('pointerdown');
    await page.waitForTimeout(500);
    await shot('drive-stopped');
    await page.locator('.hold').hover();
    await page.mouse.down();
    await page.waitForTimeout(2300);
    await page.mouse.up();
    await page.goto(`${fake.url}#/exercises`);
    await page.waitForTimeout(300);
    await shot('exercises-10m');
    for (const [task, lead] of [
      ['up_and_go', 0],
      ['turn_360', 1],
      ['eight', 0],
      ['walk_6min', 1],
      ['square', 2],
      ['circle', 2],
    ]) {
      await page.selectOption('.task-field select', task);
      await page.locator('.task-controls .choice button').nth(lead).click();
      await page.waitForTimeout(300);
      await shot(`exercises-${task}`);
    }
    await page.click('.walk-controls .primary');
    await page.waitForTimeout(500);
    await shot('exercises-begun');
    await page.locator('.go').scrollIntoViewIfNeeded();
    const go = await page.locator('.go').boundingBox();
    await page.mouse.move(go.x + go.width / 2, go.y + go.height / 2);
    await page.mouse.down();
    await page.waitForTimeout(5000);
    await shot('exercises-held');
    await page.mouse.up();
    await page.click('.walk-controls .big');
    await page.waitForTimeout(400);
    await shot('exercises-rest');
    await page.waitForTimeout(800);
    await page.goto(`${fake.url}#/calibrate`);
    await page.waitForTimeout(600);
    await shot('calibrate-list');
    await page.click('.calibrate-buttons .hold', { delay: 2200 });
    await page.waitForTimeout(2000);
    await shot('calibrate-measuring');
    await page.waitForTimeout(2000);
    await shot('calibrate-result');
    await page.click('.calibrate-buttons .primary');
    await page.waitForTimeout(600);
    await page.locator('.calibrate-list button').nth(1).click();
    await page.click('.calibrate-buttons .primary');
    await page.waitForTimeout(600);
    await shot('calibrate-entry');
    await page.locator('.calibrate-buttons .plain').click();
    await page.waitForTimeout(600);
    await page.goto(`${fake.url}#/walk`);
    await page.click('.walk-controls .primary');
    await page.goto(`${fake.url}#/tune`);
    await page.waitForTimeout(600);
    await page.locator('input[name=lean_gain_filtered_units]').fill('42');
    await page.locator('input[name=lean_gain_filtered_units]').press('Enter');
    await page.waitForTimeout(600);
    await shot('tune-trial');
    await page.click('.trial-buttons .primary');
    await page.goto(`${fake.url}#/walk`);
    await page.waitForTimeout(300);
    await page.click('.walk-controls .big');
    await page.waitForTimeout(1500);
    fake.fault('tilt_left_lost');
    await page.goto(`${fake.url}#/health`);
    await page.waitForTimeout(600);
    await shot('health-well');
    fake.fault('node_babbling');
    fake.trouble({
      tilt_left_age_ticks: 255,
      tilt_left_heartbeats_missed: 25,
      tilt_right_lost_10s: 11,
      tilt_right_lost_frames: 48,
      drive_left_error_register: 0x11,
      drive_left_emcy_code: 0x8250,
      drive_left_emcy_count: 1,
      io_age_ticks: 120,
      io_nmt_state: 127,
      bus_load_norm: 0.93,
      bus_frames_per_s: 2004,
      bus_state: 2,
      bus_errors: 318,
      babbling_id: 0x292,
    });
    fake.event('emergency', { name: 'drive_left', code: 0x8250, item: 0, bits: 0x11 });
    await page.waitForTimeout(900);
    await shot('health-trouble');
    await page.screenshot({ path: join(out, `${size}-${look}-health-whole.png`), fullPage: true });
    for (const name of ['tune', 'sessions', 'health']) {
      await page.goto(`${fake.url}#/${name}`);
      await page.waitForTimeout(500);
      if (name === 'sessions') {
        await page.locator('.session-item').first().click();
        await page.waitForTimeout(900);
      }
      if (name === 'tune') {
        fake.values.lean_gain_filtered_units = 60;
        const field = page.locator('input[name=lean_gain_filtered_units]');
        await field.fill('400');
        await field.press('Enter');
        await page.waitForTimeout(300);
      }
      await shot(name);
    }
    for (const [name, address, ready] of [
      ['tune-history', 'tune', '.tune-history summary'],
      ['patient', 'patients/5', '.trend-plot'],
      ['settings-device', 'settings/device', '.settings-part dl'],
    ]) {
      await page.goto(`${fake.url}#/${address}`);
      await page.locator(ready).first().scrollIntoViewIfNeeded();
      if (name === 'tune-history') await page.locator(ready).click();
      await page.waitForTimeout(500);
      await shot(name);
    }
    await page.goto(`${fake.url}api/docs#create_patient`);
    await page.locator('#create_patient form').waitFor();
    await shot('docs');
    await fake.close();
    await page.waitForTimeout(1500);
    await page.goto(`${fake.url}#/walk`).catch(() => {});
    await shot('lost');
    await page.close();
  }
}
await browser.close();
