// Pictures of every screen against the fake server, to be looked at: node test-support/shots.mjs OUT_FOLDER [size …]
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { startFakeServer } from './fake_server.mjs';

const out = process.argv[2];
const sizes = { '1280x800': [1280, 800], '1024x768': [1024, 768], '390x844': [390, 844] };
const wanted = process.argv.slice(3);
mkdirSync(out, { recursive: true });
const browser = await chromium.launch({
  executablePath: process.env.CHROME_PATH ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
for (const [size, [width, height]] of Object.entries(sizes)) {
  if (wanted.length > 0 && !wanted.includes(size)) continue;
  for (const { look, language } of [{ look: 'light', language: 'en' }, { look: 'dark', language: 'de' }]) {
    const fake = await startFakeServer();
    const page = await browser.newPage({ viewport: { width, height }, colorScheme: look, locale: language });
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && console.log(`[${size} ${look}] ${message.text()}`));
    page.on('pageerror', (error) => console.log(`[${size} ${look}] ${error.stack}`));
    const shot = (name) => page.screenshot({ path: join(out, `${size}-${look}-${name}.png`) });
    await page.goto(fake.url);
    await page.waitForFunction(() => document.querySelector('.mode strong')?.textContent !== 'Starting');
    await page.waitForTimeout(600);
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
    fake.fault('tilt_left_lost');
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
    await fake.close();
    await page.waitForTimeout(1500);
    await page.goto(`${fake.url}#/walk`).catch(() => {});
    await shot('lost');
    await page.close();
  }
}
await browser.close();
