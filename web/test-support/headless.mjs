// The browser of the tests: Chromium without a window, which computes half of what the whole program does for the same pages.
import { existsSync } from 'node:fs';

/** Its file; undefined where there is none. */
export const browserProgram = [process.env.CHROME_PATH, '/usr/bin/chromium-headless-shell', '/usr/bin/chromium'].find(
  (path) => path && existsSync(path),
);

/** Runs in a page: it draws ten times a second, as on a slow tablet. Drawing without a graphics processor is most of what a browser computes. */
export function drawLess() {
  const draw = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (callback) => setTimeout(() => draw(callback), 100);
  window.cancelAnimationFrame = (timer) => clearTimeout(timer);
}
